/* The teacher's page: the whole class as it comes over one line, and buttons that are asked for by
   POST. All that students have written is set as text. */
{
  const at = (id) => document.getElementById(id);
  const make = (kind, style, text) => {
    const made = document.createElement(kind);
    if (style) made.className = style;
    if (text !== undefined) made.textContent = text;
    return made;
  };
  const button = (text, act, style) => {
    const made = make("button", style, text);
    made.type = "button";
    made.addEventListener("click", act);
    return made;
  };
  let known = null, quiet = 0;

  const tell = (words) => {
    at("said").textContent = words;
    clearTimeout(quiet);
    quiet = setTimeout(() => { at("said").textContent = ""; }, 4000);
  };
  const say = async (values) => {
    try {
      const answer = await fetch("class/do", {
        method: "POST", credentials: "same-origin", cache: "no-store", body: JSON.stringify(values),
        headers: { "X-Flockscope": "class", "Content-Type": "application/json" } });
      tell((await answer.text()).trim());
      return answer.ok;
    } catch { tell("The class does not answer."); return false; }
  };
  window.flockscopeClass = { at, make, button, tell, say, known: () => known, changed: [] };

  /* Colours of headings are those of the laboratory: an even wheel, blue to the right. */
  const EAST = 255 * Math.PI / 180, YELLOW = 95 * Math.PI / 180;
  const drawn = (canvas, seen) => {
    const context = canvas.getContext("2d"), { width, height } = canvas;
    context.clearRect(0, 0, width, height);
    if (!seen || !seen.dots) return;
    const bytes = Uint8Array.from(atob(seen.dots), (one) => one.charCodeAt(0));
    const wide = Math.min(width - 8, (height - 8) * seen.shape), tall = wide / seen.shape;
    const left = (width - wide) / 2, top = (height + tall) / 2;
    const half = bytes.length > 900 ? 2 : 3;
    for (let row = 0; row < bytes.length; row += 3) {
      const angle = bytes[row + 2] / 256 * 2 * Math.PI, hue = angle + EAST;
      const x = left + bytes[row] / 255 * wide, y = top - bytes[row + 1] / 255 * tall;
      context.fillStyle = `oklch(${0.675 + 0.085 * Math.cos(hue - YELLOW)} 0.15 ${hue}rad)`;
      context.beginPath();
      context.moveTo(x + 2.2 * half * Math.cos(angle), y - 2.2 * half * Math.sin(angle));
      context.lineTo(x + 1.4 * half * Math.cos(angle + 2.5), y - 1.4 * half * Math.sin(angle + 2.5));
      context.lineTo(x + 1.4 * half * Math.cos(angle - 2.5), y - 1.4 * half * Math.sin(angle - 2.5));
      context.fill();
    }
  };
  const few = (value) => Math.abs(value) >= 100 ? value.toFixed(0) : Math.abs(value) < 1 ? value.toFixed(3) : value.toPrecision(3);
  const stands = (one) => !one.seen ? "" : one.seen.error ? "stopped by an error" :
    one.seen.compiling ? "compiling" : `tick ${one.seen.tick}${one.seen.running ? "" : ", paused"}`;
  /* The value that a student tries for the question, and whether it is handed in. */
  const answered = (one) => {
    if (!known.question || !one.number || (one.role !== "own" && !one.handed)) return "";
    const value = one.value && `${known.question.x.symbol} = ${one.value}`, played = one.kind && `plays ${one.kind}`;
    return [played, value, one.handed > 1 ? `handed in ${one.handed} times` : one.handed ? "handed in" : "not handed in"]
      .filter(Boolean).join(", ");
  };
  const cards = new Map();
  const cardOf = (number) => {
    const card = make("article", "fs-student"), canvas = make("canvas"), inner = make("div");
    Object.assign(canvas, { width: 312, height: 208 });
    canvas.setAttribute("aria-hidden", "true");
    const parts = { card, canvas, name: make("b"), model: make("span"), stands: make("span"),
      answer: make("span", "fs-answer"),
      numbers: make("span", "fs-numbers"), note: make("span", "fs-note"), acts: make("div", "fs-acts"), open: make("a", "fs-button", "Open") };
    parts.open.target = `flockscope-${number || "mine"}`;
    parts.open.href = number ? `at/${number}/` : "./";
    parts.role = button("", () => say({ do: "role", students: [number],
      role: parts.is === "own" ? "watching" : "own" }));
    parts.hold = button("", () => say({ do: "freeze", held: !parts.held, students: [number] }));
    parts.remove = button("Remove", () => {
      const sure = parts.remove.textContent !== "Remove";
      parts.remove.textContent = sure ? "Remove" : "Really?";
      if (sure) say({ do: "remove", students: [number] });
      else setTimeout(() => { parts.remove.textContent = "Remove"; }, 4000);
    });
    parts.acts.append(parts.open, ...(number ? [parts.role, parts.hold, parts.remove] : []));
    card.classList.toggle("fs-mine", !number);
    inner.append(parts.name, parts.model, parts.stands, parts.answer, parts.numbers, parts.note, parts.acts);
    card.append(canvas, inner);
    return parts;
  };
  const show = (one) => {
    if (!cards.has(one.number)) cards.set(one.number, cardOf(one.number));
    const parts = cards.get(one.number), own = one.role === "own";
    parts.is = one.role;
    parts.held = one.frozen;
    parts.card.classList.toggle("fs-away", !one.here);
    parts.name.textContent = parts.name.title = one.name;
    parts.card.setAttribute("aria-label", one.name);
    const apart = own && known.browsers && one.number > 0; // in their browser, where nobody else looks
    parts.model.textContent = apart ? "flock in their browser" : own ? one.seen ? one.seen.model : "own flock" : "watching";
    parts.stands.textContent = !one.here ? "not here" : !own ? "sees my flock" :
      one.frozen ? `frozen${apart ? "" : `, ${stands(one)}`}` : apart ? "here" : stands(one);
    parts.answer.textContent = parts.answer.title = answered(one);
    parts.numbers.textContent = own && !apart && one.seen ? one.seen.numbers.map(([title, value]) => `${title} ${few(value)}`).join("\n") : "";
    parts.note.textContent = one.note || "";
    parts.note.hidden = !one.note;
    parts.role.textContent = own ? "Watch mine" : "Own flock";
    parts.hold.textContent = one.frozen ? "Go on" : "Freeze";
    parts.hold.hidden = !own;
    parts.open.hidden = parts.canvas.hidden = !own || apart;
    if (own && !apart) drawn(parts.canvas, one.seen);
    return parts.card;
  };
  const shown = (text, line) => {
    known = JSON.parse(text);
    at("lost").hidden = true;
    at("unkept").textContent = known.unkept && `The class is not kept: ${known.unkept}. It is tried again; “End of class” saves it on this machine.`;
    at("unkept").hidden = !known.unkept;
    at("flocks").textContent = known.flocks;
    at("flocks").hidden = !known.flocks;
    at("title").textContent = known.title;
    const here = known.students.filter((one) => one.here).length;
    at("count").textContent = `${here} here of ${known.students.length}, ${known.seats} seats`;
    at("freeze").textContent = known.frozen ? "All go on" : "Freeze all";
    at("freeze").setAttribute("aria-pressed", String(known.frozen));
    at("watch").setAttribute("aria-pressed", String(known.first === "watching"));
    at("own").setAttribute("aria-pressed", String(known.first === "own"));
    const place = at("students");
    const mine = { number: 0, name: "My flock", role: "own", here: true, seen: known.mine };
    const wanted = [...(known.students.length ? [mine] : []), ...known.students].map(show);
    for (const [number, parts] of cards) {
      if (!known.students.some((one) => one.number === number || !number)) { parts.card.remove(); cards.delete(number); }
    }
    wanted.forEach((card, row) => { if (place.children[row] !== card) place.insertBefore(card, place.children[row] || null); });
    invite(place, wanted.length > 0 || known.over);
    for (const act of window.flockscopeClass.changed) act(known);
    if (!known.over) return;
    line.close();
    at("lost").textContent = "The class has ended.";
    at("lost").hidden = false;
  };
  /* While nobody is in, the code stands on the page as large as on the wall. */
  const invite = (place, enough) => {
    const now = place.querySelector(".fs-none"), links = known.links.join();
    if (enough) return now && now.remove();
    if (now && now.dataset.links === links) return;
    const made = make("div", "fs-none");
    made.dataset.links = links;
    made.append(make("p", "", "Nobody is here yet. Students enter with this code, or at this address:"),
      window.flockscopeWall(known.links, say));
    if (now) now.replaceWith(made); else place.append(made);
  };
  const sheet = (content) => {
    const one = at("sheet");
    one.replaceChildren(content);
    if (!one.open) one.showModal();
  };
  const close = () => at("sheet").close();
  Object.assign(window.flockscopeClass, { sheet, close });
  const wall = () => {
    if (known) sheet(window.flockscopeWall(known.links, async (values) => {
      if (await say(values)) setTimeout(wall, 600);
    }, close));
  };
  const listen = () => {
    const line = new EventSource("class/roster");
    line.onmessage = (event) => shown(event.data, line);
    line.onerror = () => {
      at("lost").textContent = "The class does not answer; what is shown is from before. Trying again.";
      at("lost").hidden = false;
      if (line.readyState === EventSource.CLOSED) setTimeout(listen, 2000);
    };
  };
  document.addEventListener("DOMContentLoaded", () => {
    at("watch").addEventListener("click", () => say({ do: "role", role: "watching" }));
    at("own").addEventListener("click", () => say({ do: "role", role: "own" }));
    at("start").addEventListener("click", () => {
      if (!known?.lesson?.steps.some(({ predicted }) => predicted.some(Boolean))) return say({ do: "start" });
      const inner = make("div", "fs-asking"), link = make("a", "fs-button", "Predictions (CSV)");
      Object.assign(link, { href: "class/predictions.csv", download: "" });
      inner.append(make("h2", "", "All start from my scene"),
        make("p", "", "If your scene has other steps, the class forgets what students have predicted: save it first."), link,
        button("Start", async () => { if (await say({ do: "start" })) close(); }),
        button("Go on", close));
      sheet(inner);
    });
    at("freeze").addEventListener("click", () => say({ do: "freeze", held: !known.frozen }));
    at("show-code").addEventListener("click", wall);
    at("say").addEventListener("submit", async (event) => {
      event.preventDefault();
      if (await say({ do: "say", word: at("word").value })) at("word").select();
    });
    window.addEventListener("keydown", (event) => {
      const field = event.target.closest("input, textarea, select");
      if (event.key.toLowerCase() !== "q" || field || event.ctrlKey || event.metaKey || event.altKey) return;
      if (at("sheet").open) close(); else wall();
    });
    at("end").addEventListener("click", () => {
      const inner = make("div", "fs-asking"), link = make("a", "fs-button fs-main", "Save the class as a file");
      Object.assign(link, { href: "class/class.zip", download: "" });
      inner.append(make("h2", "", "End of class"),
        make("p", "", "One file has all flocks, results and plots; flockscope class FILE opens it again."), link,
        button("End the class for all", async () => { if (await say({ do: "end" })) close(); }),
        button("Go on", close));
      sheet(inner);
    });
    listen();
  });
}
