// Has a page show agents that differ: colours and numbers of kinds, whom an agent heeds, and sliders by kind.
function showKinds() {
  const { colours, role } = Look.prototype, { neighbours } = View.prototype;
  const { addSlider, areZonesInOrder, begin, reset } = Page.prototype;
  const dotOf = (manifest, number) => {
    const dot = element("span", "");
    dot.className = "dot";
    dot.style.background = css(unhex(manifest.palette.kind)[number]);
    return dot;
  };

  Object.assign(Look.prototype, {
    // Whoever is caught and stands still is grey, whatever colours mean.
    colours(now) {
      const frame = { ...now, values: now.own[this.select.value] };
      const { kind, crashed, informed } = frame, { palette } = this.view.manifest;
      if (!kind.length) return colours.call(this, frame);
      const own = unhex(palette.kind), [caught] = unhex(palette.caught), isByKind = this.select.value === "kind";
      const inks = isByKind ? new Uint8Array(4 * kind.length) : colours.call(this, frame);
      kind.forEach((number, row) => {
        if (crashed[row]) { if (isByKind) inks.set(this.crashed, 4 * row); }
        else if (number < 0) inks.set(caught, 4 * row);
        else if (isByKind) inks.set(informed[row] ? this.informed : own[number], 4 * row);
      });
      if (isByKind) this.explainKinds(frame, own, caught);
      return inks;
    },
    // The kinds with how many there are of each now.
    explainKinds({ kind, crashed, informed }, inks, caught) {
      const { manifest, canvas, tick } = this.view;
      canvas.setAttribute("aria-label", `${kind.length} agents, coloured by kind, tick ${tick}`);
      const counts = manifest.differ.kinds.map((_, number) => kind.reduce((sum, one) => sum + (one === number), 0));
      const still = kind.reduce((sum, one) => sum + (one < 0), 0);
      const said = [counts, still, crashed.includes(1), informed.includes(1)].join();
      if (said === this.said) return;
      this.said = said;
      this.legend.replaceChildren();
      manifest.differ.kinds.forEach(({ name }, number) => this.addEntry(`${name} ${grouped(counts[number])}`, inks[number]));
      if (still) this.addEntry(`caught ${grouped(still)}`, caught);
      if (informed.includes(1)) this.addEntry("information agent", this.informed);
      if (crashed.includes(1)) this.addEntry("crashed", this.crashed);
    },
    role(frame, row) {
      const kind = frame.kind[row], name = kind < 0 ? "caught" : this.view.manifest.differ.kinds[kind]?.name;
      return (name ? `, ${name}` : "") + role.call(this, frame, row);
    },
  });

  Object.assign(View.prototype, {
    // Whom it heeds, as far as it notices others.
    neighbours(frame, row) {
      const { heeds } = this.manifest.differ, { kind, reaches } = frame;
      const near = neighbours.call(this, { ...frame, reach: reaches[row] }, row);
      return kind.length ? near.filter((other) => heeds[kind[row]]?.[kind[other.row]]) : near;
    },
  });

  Object.assign(Page.prototype, {
    begin() {
      if (this.kinds.length) this.addCounts();
      return begin.call(this);
    },
    // How many agents each kind has: another number begins the flock anew, with the same seed.
    addCounts() {
      const counts = Object.assign(element("div", ""), { id: "counts" }), first = $("agents").parentElement;
      const name = (label, number) => {
        const words = element("span", this.manifest.differ.kinds[number].name);
        words.prepend(dotOf(this.manifest, number));
        label.prepend(words);
      };
      first.firstChild.remove();
      name(first, 0);
      this.fields = this.kinds.map((_, k) => {
        const label = element("label", ""), field = Object.assign(element("input", ""), { type: "number", min: 0, max: MOST_AGENTS });
        label.append(field);
        name(label, k + 1);
        field.onchange = () => this.beginAnew($("agents").value, $("seed").value, this.fields.map((one) => one.value));
        return field;
      });
      counts.append(first, ...this.fields.map((field) => field.parentElement));
      $("anew").prepend(counts, element("small", `Agents of each kind, ${grouped(MOST_AGENTS)} at most in all.`));
    },
    reset() {
      this.fields?.forEach((field, k) => { field.value = this.others[k]; });
      return reset.call(this);
    },
    faultOfKinds(agents, others) {
      const wrong = others.findIndex((count) => !/^\d{1,5}$/.test(count) || count > MOST_AGENTS);
      const all = others.reduce((sum, count) => sum + +count, agents + this.manifest.start.informed);
      return wrong >= 0 ? `${this.kinds[wrong].name}: a whole number from 0 to ${grouped(MOST_AGENTS)} agents.`
        : all > MOST_AGENTS ? `${grouped(all)} agents are too many: ${grouped(MOST_AGENTS)} at most in all.` : "";
    },
    // The sliders of a kind stand below its name.
    addSlider(parameter) {
      const { group } = parameter, { differ } = this.manifest;
      if (group && group !== this.group) {
        const title = element("h2", group);
        title.prepend(dotOf(this.manifest, differ.kinds.findIndex(({ name }) => name === group)));
        $("sliders").append(title);
        this.group = group;
      }
      addSlider.call(this, parameter);
      if (!group) return;
      const input = $("sliders").lastElementChild.querySelector("input");
      input.setAttribute("aria-label", `${group}: ${input.getAttribute("aria-label")}`);
    },
    // Also those of each kind.
    areZonesInOrder(valueOf) {
      const kinds = this.manifest.differ.kinds.map(({ name }) => (one) => this.values[`${name}.${one}`] ?? valueOf(one));
      return [valueOf, ...kinds].every((own) => areZonesInOrder.call(this, own));
    },
  });
}
