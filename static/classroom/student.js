/* What a student's page shows of the class: who one is, whose flock it is, a word of the teacher's.
   When the class shows this page another flock, viser's client is told to connect anew: the page
   stays. The class says so over one line, which the browser mends by itself. */
{
  const home = location.pathname.replace(/\/(index\.html)?$/, "");
  const root = document.documentElement;
  const Worker = window.Worker;
  let client = null, moves = null;
  window.Worker = class extends Worker {
    constructor(...given) {
      super(...given);
      client = client || this;
    }
  };
  const make = (kind, style) => {
    const made = document.createElement(kind);
    made.className = style;
    return made;
  };
  const bar = make("div", "fs-class"), who = make("b", ""), what = make("span", "");
  const word = make("p", "fs-word");
  bar.setAttribute("role", "status");
  bar.append(who, what);
  const over = (words) => {
    const sheet = make("div", "fs-lost"), inner = document.createElement("div");
    sheet.setAttribute("role", "alert");
    inner.append(Object.assign(document.createElement("b"), { textContent: words }));
    sheet.append(inner);
    document.body.append(sheet);
  };
  let ended = false;
  const shown = (text, line) => {
    const told = JSON.parse(text);
    if (told.over && !ended) {
      ended = true;
      line.close();
      over("This class is over for you.");
      return;
    }
    root.dataset.role = told.role;
    root.dataset.held = String(told.frozen && told.role === "own");
    who.textContent = told.name;
    what.textContent = told.role === "watching" ? "watching the teacher’s flock" :
      told.frozen ? "your own flock, held by the teacher" : "your own flock";
    word.textContent = told.word;
    word.hidden = !told.word;
    if (moves !== null && told.moves !== moves && client) client.postMessage({ type: "retry" });
    moves = told.moves;
    for (const act of window.flockscopeStudent.changed) act(told);
  };
  window.flockscopeStudent = { bar, home, changed: [] };
  const listen = () => {
    const line = new EventSource(`${home}/class/mine`);
    line.onmessage = (event) => shown(event.data, line);
    line.onerror = () => {
      if (line.readyState === EventSource.CLOSED && !ended) setTimeout(listen, 2000);
    };
  };
  document.addEventListener("DOMContentLoaded", () => {
    document.body.append(word, bar);
    listen();
  });
}
