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
  const word = make("p", "fs-word"), asked = make("div", "fs-question");
  asked.setAttribute("role", "status");
  bar.setAttribute("role", "status");
  bar.append(who, what);
  let ended = false;
  const shown = (text, line) => {
    const told = JSON.parse(text);
    if (told.over && !ended) {
      ended = true;
      line.close();
      if (told.removed) window.flockscopeEnded("You are no longer in this class", "The code on the wall lets you in again.");
      else window.flockscopeEnded("The class has ended", told.role === "own" ?
        "Your flock is kept with the class. What you see here stands still." : "What you see here stands still.");
      return;
    }
    if (told.page === "flock") {
      line.close();
      location.reload(); // one's own flock runs in another page
      return;
    }
    root.dataset.role = told.role;
    root.dataset.held = String(told.frozen && told.role === "own");
    who.textContent = told.name;
    what.textContent = told.role === "watching" ? "watching the teacher’s flock" :
      told.frozen ? "your own flock, held by the teacher" : "your own flock";
    word.textContent = told.word;
    word.hidden = !told.word;
    ask(told);
    if (moves !== null && told.moves !== moves && client) client.postMessage({ type: "retry" });
    moves = told.moves;
  };
  /* The question, the value that one has to try, and a button that hands the run in as it is set up. */
  const title = document.createElement("b"), task = document.createElement("p");
  const hand = document.createElement("button"), said = make("p", "fs-answer");
  hand.type = "button";
  asked.append(title, task, hand, said);
  hand.addEventListener("click", async () => {
    hand.disabled = true;
    said.textContent = "Your run is made and measured …";
    try {
      const answer = await fetch(`${home}/class/hand-in`, { method: "POST", body: "{}", cache: "no-store",
        credentials: "same-origin", headers: { "X-Flockscope": "class", "Content-Type": "application/json" } });
      said.textContent = (await answer.text()).trim();
    } catch { said.textContent = "The class does not answer."; }
    hand.disabled = false;
  });
  let before = null;
  const ask = ({ question, role }) => {
    asked.hidden = !question || role !== "own";
    if (!question) return;
    if (before !== question.title + question.value) said.textContent = "";
    before = question.title + question.value;
    title.textContent = question.title;
    task.textContent = question.value === null ?
      `Choose ${question.parameter.toLowerCase()} and watch: ${question.measured}.` :
      `Yours: ${question.parameter.toLowerCase()} ${question.value}. Watch ${question.measured}.`;
    hand.textContent = question.handed ? `Hand in again (${question.handed})` : "Hand in my run";
  };
  const listen = () => {
    const line = new EventSource(`${home}/class/mine`);
    line.onmessage = (event) => shown(event.data, line);
    line.onerror = () => {
      if (line.readyState === EventSource.CLOSED && !ended) setTimeout(listen, 2000);
    };
  };
  document.addEventListener("DOMContentLoaded", () => {
    document.body.append(word, asked, bar);
    listen();
  });
}
