/* A page of our own looks as the laboratory does in this browser: light or dark, and how large its
   text is. */
{
  const root = document.documentElement, dark = matchMedia("(prefers-color-scheme: dark)");
  const kept = (name) => { try { return localStorage.getItem(`flockscope-${name}`); } catch { return null; } };
  const theme = () => {
    const chosen = kept("theme");
    root.dataset.theme = ["light", "dark"].includes(chosen) ? chosen : dark.matches ? "dark" : "light";
  };
  theme();
  root.dataset.text = ["S", "M", "L"].includes(kept("text")) ? kept("text") : "M";
  dark.addEventListener("change", theme);
}
