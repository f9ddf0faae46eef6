/* What one takes along of what this browser shows: a picture, or a film from now until "Stop". The
   server makes them of what this browser draws; it tells this page alone the name to ask by. */
{
  const { make, button, sheet, close, complain } = window.flockscopeSheet;
  const way = location.pathname.replace(/\/(index\.html)?$/, "") + "/take.json";
  const kinds = {
    picture: { png: "PNG, as seen here", svg: "SVG, a plan", pdf: "PDF, a plan" },
    film: { mp4: "MP4", webm: "WebM", gif: "GIF", html: "HTML, a page that plays" } };
  const sizes = {
    picture: ["1280x800", "1600x1000", "1920x1080", "2560x1440", "3840x2160", "800x800"],
    film: ["1280x720", "854x480", "640x360", "1920x1080", "720x720"] };
  let me = null, state = null, sign = null, due = 0;

  const ask = async (more) => {
    const canvas = document.querySelector("canvas[data-engine]");
    const asked = new URLSearchParams({
      me: me || "", theme: document.documentElement.dataset.theme || "light",
      dots: canvas ? String(canvas.width / Math.max(canvas.clientWidth, 1)) : "1", ...more });
    let answer;
    try {
      answer = await fetch(`${way}?${asked}`, { headers: { "X-Flockscope": "scene" },
        cache: "no-store", credentials: "same-origin" });
    } catch { throw new Error("The server does not answer."); }
    if (!answer.ok) throw new Error((await answer.text()).trim());
    state = await answer.json();
    return state;
  };

  const choice = (name, entries, chosen) => {
    const label = make("label", "", name), made = make("select");
    for (const [value, text] of entries) {
      const option = make("option", "", text);
      option.value = value;
      made.append(option);
    }
    if (chosen) made.value = chosen;
    label.append(made);
    return { label, made };
  };
  const part = (inner, what, title, word, act) => {
    const made = make("section", "fs-take"), row = make("div");
    const kind = choice("Format", Object.entries(kinds[what]));
    const size = choice("Pixels", sizes[what].map((one) => [one, one.replace("x", " × ")]));
    const go = button("fs-main", word, () => act(kind.made.value, size.made.value, go));
    row.append(kind.label, size.label, go);
    made.append(make("h3", "", title), row);
    inner.append(made);
    return { kind: kind.made, size: size.made, made };
  };

  /* How far it is with what is being made, under the buttons on the picture. */
  const show = () => {
    const words = state.filming ?
      state.ending ? "Making the film ..." :
      `Recording ${Math.floor(state.seconds / 60)}:${String(Math.floor(state.seconds % 60)).padStart(2, "0")}` +
      (state.bytes ? `, ${(state.bytes / 1e6).toFixed(1)} MB` : "") : state.busy ? "Making the file ..." : "";
    if (!words && sign) { sign.remove(); sign = null; }
    if (!words) return;
    if (sign === null) {
      sign = make("div", "fs-recording");
      sign.setAttribute("role", "status");
      sign.append(make("i"), make("span"),
        button("", "Stop", () => follow({ do: "stop" })), button("", "Discard", () => follow({ do: "discard" })));
      document.body.append(sign);
    }
    sign.querySelector("span").textContent = words;
    sign.classList.toggle("fs-making", !state.filming || state.ending);
  };
  const follow = async (more) => {
    clearTimeout(due);
    try { await ask(more || {}); }
    catch (why) {
      if (sign) { sign.remove(); sign = null; }
      complain(sheet("Not taken", "fs-ask"), why.message);
      return;
    }
    show();
    if (state.said) complain(sheet("Not taken", "fs-ask"), state.said);
    if (state.cut) complain(sheet("Taken, but cut", "fs-ask"), state.cut);
    if (state.filming || state.busy) due = setTimeout(follow, 500);
  };

  const take = async () => {
    const inner = sheet("Take it with you", "fs-share");
    try { await ask({}); } catch (why) { return complain(inner, why.message); }
    const begin = (what) => async (kind, size, go) => {
      go.disabled = true;
      try { await ask({ do: what, kind, size }); }
      catch (why) { go.disabled = false; return complain(inner, why.message); }
      close();
      follow();
    };
    const still = part(inner, "picture", "Picture", "Save picture", begin("picture"));
    if (!state.flat) for (const kind of ["svg", "pdf"]) still.kind.querySelector(`[value=${kind}]`).disabled = true;
    const film = part(inner, "film", "Film", "Record", begin("film"));
    film.made.append(make("p", "fs-quiet", "What this browser shows from now on, until Stop: at most " +
      `three minutes, as HTML ${Math.round(state.html_seconds)} s of so many agents. HTML plays by itself, and ` +
      "whoever opens it turns it round."));
    if (state.missing) {
      film.made.append(make("p", "fs-quiet", `MP4, WebM, GIF: ${state.missing}`));
      for (const kind of ["mp4", "webm", "gif"]) film.kind.querySelector(`[value=${kind}]`).disabled = true;
      film.kind.value = "html";
    }
    const fit = () => { film.size.disabled = film.kind.value === "html"; };
    film.kind.addEventListener("change", fit);
    fit();
    const page = make("section", "fs-take"), row = make("div");
    const go = button("fs-main", "Save page", () => begin("page")("", "", go));
    row.append(go);
    page.append(make("h3", "", "Page that runs"), row, make("p", "fs-quiet", (state.pair ?
      "Both flocks from where they are now, with their" : "The flock from its start, with its") +
      " sliders and charts, as one HTML file: it runs in any browser, without this server. To make it takes " +
      `some ${state.pair ? 40 : 20} seconds.`));
    inner.append(page);
    if (state.filming || state.busy) complain(inner, "One thing at a time: it is being made.");
  };

  window.flockscopeTake = take;

  viserClient.onMessage((message) => {
    const text = message.type === "GuiHtmlMessage" && message.props && message.props.content;
    const found = text && /data-fs-me="([\w-]+)"/.exec(text);
    if (found) me = found[1];
  });
  document.addEventListener("DOMContentLoaded", () => {
    document.querySelector(".fs-open").append(button("", "Take", take));
  });
}
