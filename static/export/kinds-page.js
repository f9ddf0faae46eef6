// Has a page show agents that differ: colours and numbers of kinds, whom an agent heeds, and sliders by kind.
function showKinds() {
  const { colours, role } = Look.prototype, { neighbours } = View.prototype;
  const { addSlider, areZonesInOrder } = Page.prototype;

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
    // The sliders of a kind stand below its name.
    addSlider(parameter) {
      const { group } = parameter, { differ, palette } = this.manifest;
      if (group && group !== this.group) {
        const title = element("h2", group), dot = element("span", "");
        const number = differ.kinds.findIndex(({ name }) => name === group);
        dot.className = "dot";
        dot.style.background = css(unhex(palette.kind)[number]);
        title.prepend(dot);
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
