/* What a student's page shows of the class: who one is, whose flock it is, a word of the teacher's.
   When the class shows this page another flock, viser's client is told to connect anew: the page
   stays. The class says so over one line, which the browser mends by itself. */
{
  const home = location.pathname.replace(/\/(index\.html)?$/, "");
  const root = document.documentElement;
  let moves = null;
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
      results.end();
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
    results.look(told.plot);
    if (moves !== null && told.moves !== moves) viserClient.reconnect();
    moves = told.moves;
  };
  /* The question, the value that one has to try, and a button that hands the run in as it is set up. */
  const title = document.createElement("b"), task = document.createElement("p");
  const hand = document.createElement("button"), said = make("p", "fs-answer"), now = make("p", "fs-now");
  hand.type = "button";
  /* The class's results beside it; they open with one's own first result. */
  const chart = make("div", "fs-chart"), plot = make("details", "fs-results"), head = document.createElement("summary");
  chart.dataset.least = "150";
  plot.append(head, chart);
  plot.hidden = true;
  asked.append(title, task, now, hand, said, plot);
  const fits = () => innerHeight > 700; /* else the picture would go for it */
  let own = 0, newest = null;
  const results = window.flockscopeResults(home, (found, mine) => {
    plot.hidden = false;
    title.textContent = found.title;
    head.textContent = `The class: ${found.told}`;
    window.flockscopeChart(chart, found, null, mine);
    if (!own && mine.length) plot.open = fits();
    own = mine.length;
    ask(newest);
  });
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
  const ask = (told) => {
    const { question, role } = newest = told;
    asked.hidden = role !== "own" || !question && plot.hidden;
    hand.hidden = task.hidden = now.hidden = !question; /* what was handed in stays, with the results */
    if (!question) return;
    if (before !== question.title + question.value + question.kind) {
      said.textContent = question.answer;
      plot.open = question.handed > 0 && fits();
      own = question.handed;
    }
    before = question.title + question.value + question.kind;
    title.textContent = question.title;
    const played = question.kind ? `You are: ${question.kind}. ` : "";
    task.textContent = played + (question.value === null ?
      `Choose ${question.parameter.toLowerCase()} and watch: ${question.measured}.` :
      `Yours: ${question.parameter.toLowerCase()} ${question.value}. Watch ${question.measured}.`);
    now.textContent = question.now;
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
