/* The address of the class and its picture, large: for the wall. `links` are the addresses, the
   likeliest first; the page's own address is taken where others can reach it too. It has a button that
   closes it if there is `close`. */
window.flockscopeWall = (links, say, close) => {
  const loopback = ["localhost", "127.0.0.1", "[::1]"].includes(location.hostname);
  const home = location.origin + location.pathname.replace(/(class|index\.html)?$/, "");
  const code = links[0].slice(links[0].lastIndexOf("/") + 1);
  if (!loopback) links = [home + code, ...links.filter((link) => link !== home + code)];
  let at = links[0];
  const made = document.createElement("div"), picture = document.createElement("img");
  const words = document.createElement("p"), below = document.createElement("div");
  made.className = "fs-wall";
  const show = () => {
    picture.src = `class/code.svg?at=${encodeURIComponent(at)}`;
    picture.alt = `QR code of ${at}`;
    words.textContent = at.replace(/^http:\/\//, "");
  };
  const button = (text, act) => {
    const one = document.createElement("button");
    one.type = "button";
    one.textContent = text;
    one.addEventListener("click", act);
    return one;
  };
  if (links.length > 1) below.append(button("Another address", () => {
    at = links[(links.indexOf(at) + 1) % links.length];
    show();
  }));
  below.append(button("New code", () => say({ do: "renew" })));
  if (close) below.append(Object.assign(button("Close", close), { autofocus: true }));
  made.append(picture, words, below);
  show();
  return made;
};
