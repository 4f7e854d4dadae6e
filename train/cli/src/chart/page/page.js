"use strict";
(() => {
  const { chart, axes, pictures } = JSON.parse(document.getElementById("data").textContent);
  const COLORS = ["#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9"];
  const BEATEN = "#bebebe";
  const SIZE = { width: 760, height: 460, left: 64, right: 18, top: 14, bottom: 46 };
  const points = chart.points;
  const byId = (id) => document.getElementById(id);
  const isOurs = (p) => p.program === "pocketnerf";
  const seriesOf = (p) => (isOurs(p) ? p.method : p.program);
  const groupOf = (p) => `${p.scene} ${p.width}x${p.height}`;
  const unique = (list) => [...new Set(list)];
  const series = unique(points.map(seriesOf));
  const colorOf = (p) => COLORS[series.indexOf(seriesOf(p)) % COLORS.length];
  const hidden = new Set();
  let kept = null;

  const make = (name, attributes = {}, text) => {
    const element = document.createElement(name);
    for (const [key, value] of Object.entries(attributes)) element.setAttribute(key, value);
    if (text !== undefined) element.textContent = text;
    return element;
  };
  const draw = (name, attributes, text) => {
    const element = document.createElementNS("http://www.w3.org/2000/svg", name);
    for (const [key, value] of Object.entries(attributes)) element.setAttribute(key, value);
    if (text !== undefined) element.textContent = text;
    return element;
  };
  const known = (axis, p) => Number.isFinite(p[axis.key]);
  const short = (value) => {
    if (value === null || value === undefined) return "";
    if (typeof value !== "number") return String(value);
    if (Number.isInteger(value)) return value.toLocaleString("en");
    const digits = Math.abs(value) >= 1000 ? 0 : Math.abs(value) >= 10 ? 2 : 4;
    return value.toLocaleString("en", { maximumFractionDigits: digits });
  };
  const tick = (value) => {
    const [scaled, unit] = value >= 1e9 ? [value / 1e9, "G"] : value >= 1e6 ? [value / 1e6, "M"]
      : value >= 1e4 ? [value / 1e3, "k"] : [value, ""];
    return Number(scaled.toPrecision(4)) + unit;
  };

  // What can be chosen: axes that some point has a figure for.
  const offered = axes.filter((axis) => points.some((p) => known(axis, p)));
  const axisOf = (id) => offered.find((axis) => axis.key === byId(id).value);
  const fill = (id, options) => {
    for (const [value, text] of options) byId(id).append(make("option", { value }, text));
  };
  const option = (axis) => [axis.key, axis.label];
  fill("group", unique(points.map(groupOf)).map((group) => [group, group]));
  fill("y", offered.filter((axis) => axis.accuracy).map(option));
  fill("x", offered.filter((axis) => !axis.accuracy).map(option));
  for (const name of series) {
    const label = make("label");
    const box = make("input", { type: "checkbox", value: name, checked: "" });
    const swatch = make("span", { class: "swatch" });
    swatch.style.background = COLORS[series.indexOf(name) % COLORS.length];
    box.addEventListener("change", () => {
      if (box.checked) hidden.delete(name); else hidden.add(name);
      show();
    });
    label.append(box, swatch, name);
    byId("methods").append(label);
  }

  // As `frontier` of the program: no other point is as good on both axes and better on one.
  const frontier = (shown, x, y) => {
    const cost = (axis, p) => (axis.more_is_better ? -p[axis.key] : p[axis.key]);
    const beats = (a, b) => cost(x, a) <= cost(x, b) && cost(y, a) <= cost(y, b)
      && (cost(x, a) < cost(x, b) || cost(y, a) < cost(y, b));
    return new Set(shown.filter((p) =>
      !shown.some((other) => other.program === p.program && beats(other, p))));
  };

  const logTicks = (low, high) => {
    const ticks = [];
    const steps = high / low > 30 ? [1, 3] : high / low > 8 ? [1, 2, 5] : [1, 1.5, 2, 3, 4, 5, 6, 8];
    for (let e = Math.floor(Math.log10(low)); e <= Math.ceil(Math.log10(high)); e += 1) {
      for (const step of steps) {
        const value = step * 10 ** e;
        if (value >= low && value <= high) ticks.push(value);
      }
    }
    return ticks;
  };
  const linearTicks = (low, high) => {
    const raw = (high - low) / 6;
    const power = 10 ** Math.floor(Math.log10(raw));
    const step = [1, 2, 5, 10].map((s) => s * power).find((s) => s >= raw);
    const ticks = [];
    for (let i = Math.ceil(low / step); i * step <= high; i += 1) {
      ticks.push(Number((i * step).toPrecision(12)));
    }
    return ticks;
  };

  const show = () => {
    const svg = byId("chart");
    svg.replaceChildren();
    const [x, y] = [axisOf("x"), axisOf("y")];
    const group = byId("group").value;
    const here = points.filter((p) => groupOf(p) === group && !hidden.has(seriesOf(p)));
    table(here);
    if (!x || !y) return;
    const shown = here.filter((p) => known(x, p) && known(y, p) && p[x.key] > 0);
    if (shown.length === 0) {
      svg.append(draw("text", { x: 80, y: 60 }, "No point has both figures."));
      return;
    }
    const [xs, ys] = [shown.map((p) => p[x.key]), shown.map((p) => p[y.key])];
    const room = Math.max(1.1, (Math.max(...xs) / Math.min(...xs)) ** 0.06);
    const [left, right] = [Math.min(...xs) / room, Math.max(...xs) * room];
    const space = 0.07 * (Math.max(...ys) - Math.min(...ys)) || 1e-3 * Math.abs(ys[0]) || 1e-6;
    const [low, high] = [Math.min(...ys) - space, Math.max(...ys) + space];
    const width = SIZE.width - SIZE.left - SIZE.right;
    const height = SIZE.height - SIZE.top - SIZE.bottom;
    const atX = (v) => SIZE.left + (Math.log(v / left) / Math.log(right / left)) * width;
    const atY = (v) => SIZE.top + ((high - v) / (high - low)) * height;
    const bottom = SIZE.top + height;
    for (const value of logTicks(left, right)) {
      const at = atX(value);
      svg.append(draw("line", { class: "grid", x1: at, x2: at, y1: SIZE.top, y2: bottom }));
      svg.append(draw("text", { x: at, y: bottom + 17, "text-anchor": "middle" }, tick(value)));
    }
    for (const value of linearTicks(low, high)) {
      const at = atY(value);
      svg.append(draw("line", { class: "grid", x1: SIZE.left, x2: SIZE.left + width, y1: at, y2: at }));
      svg.append(draw("text", { x: SIZE.left - 7, y: at + 4, "text-anchor": "end" }, tick(value)));
    }
    svg.append(draw("path", { class: "axis", fill: "none",
      d: `M${SIZE.left} ${SIZE.top}V${bottom}H${SIZE.left + width}` }));
    svg.append(draw("text", { x: SIZE.left + width / 2, y: SIZE.height - 8, "text-anchor": "middle" }, x.label));
    svg.append(draw("text", { "text-anchor": "middle",
      transform: `translate(14 ${SIZE.top + height / 2}) rotate(-90)` }, y.label));
    // As `Axis::is_time` of the program: hollow where the time is not to be trusted.
    const isUnsteady = (p) => p.unsteady && [x, y].some((axis) =>
      ["ms_per_frame", "rays_per_second"].includes(axis.key));
    const best = frontier(shown, x, y);
    const line = shown.filter((p) => best.has(p) && isOurs(p)).sort((a, b) => a[x.key] - b[x.key]);
    svg.append(draw("path", { class: "frontier",
      d: line.map((p, i) => `${i ? "L" : "M"}${atX(p[x.key])} ${atY(p[y.key])}`).join("") }));
    // Those that nobody beats lie above the others.
    for (const p of [...shown].sort((a, b) => best.has(a) - best.has(b))) {
      const [cx, cy] = [atX(p[x.key]), atY(p[y.key])];
      const place = isOurs(p) ? { cx, cy, r: 6.5 }
        : { points: `${cx},${cy - 8} ${cx - 7.5},${cy + 6} ${cx + 7.5},${cy + 6}` };
      const mark = draw(isOurs(p) ? "circle" : "polygon", { ...place, tabindex: 0,
        class: p === kept ? "mark kept" : "mark", "data-id": p.id,
        fill: isUnsteady(p) ? "white" : best.has(p) || !isOurs(p) ? colorOf(p) : BEATEN,
        stroke: colorOf(p) });
      mark.append(draw("title", {}, `${seriesOf(p)} ${p.model}: ${short(p[y.key])}, ${short(p[x.key])}`));
      mark.addEventListener("mouseenter", () => tell(p));
      mark.addEventListener("mouseleave", () => tell(kept));
      mark.addEventListener("focus", () => tell(p));
      mark.addEventListener("click", () => keep(p));
      svg.append(mark);
    }
  };

  const keep = (p) => {
    kept = p;
    show();
    tell(p);
  };

  const units = Object.fromEntries(axes.map((axis) => [axis.key, axis.label]));
  const describe = (list, entries) => {
    for (const [key, value] of entries) {
      if (value === null || value === undefined || value === "") continue;
      list.append(make("dt", {}, key));
      const text = make("dd");
      text.append(key.endsWith("command") ? make("code", {}, value) : short(value));
      list.append(text);
    }
  };
  const tell = (p) => {
    const details = byId("details");
    const picture = byId("picture");
    if (!p) {
      details.replaceChildren(make("p", {}, "Point at a mark."));
      picture.hidden = true;
      return;
    }
    const list = make("dl");
    const skipped = new Set(["id", "scene", "width", "height", "frontier"]);
    describe(list, Object.entries(p).filter(([key]) => !skipped.has(key))
      .map(([key, value]) => [units[key] || key.replaceAll("_", " "), value]));
    details.replaceChildren(make("h2", {}, `${seriesOf(p)} ${p.model}`), list);
    picture.hidden = !(p.id in pictures);
    if (!picture.hidden) {
      picture.querySelector("img").src = pictures[p.id];
      picture.querySelector("img").alt = `${p.model}: model, truth, difference`;
      picture.querySelector("p").textContent = `${groupOf(p)}, ${seriesOf(p)} ${p.model}`;
    }
  };

  const COLUMNS = ["method", "model", "precision", "quality", "sampling"];
  const table = (here) => {
    const figures = offered.filter((axis) => here.some((p) => known(axis, p)));
    const head = make("tr");
    for (const key of COLUMNS) head.append(make("th", { class: "text" }, key));
    for (const axis of figures) head.append(make("th", {}, axis.label));
    head.append(make("th", {}, "spread"));
    const rows = here.map((p) => {
      const row = make("tr", { class: `${p.frontier ? "best" : ""} ${p === kept ? "kept" : ""}` });
      for (const key of COLUMNS) {
        const text = key === "method" ? seriesOf(p) : short(p[key]);
        row.append(make("td", { class: "text" }, text));
      }
      for (const axis of figures) row.append(make("td", {}, short(p[axis.key])));
      const spread = known({ key: "spread" }, p) ? `${(100 * p.spread).toFixed(1)} %` : "";
      row.append(make("td", {}, p.unsteady ? `${spread} unsteady` : spread));
      row.addEventListener("mouseenter", () => tell(p));
      row.addEventListener("mouseleave", () => tell(kept));
      row.addEventListener("click", () => keep(p));
      return row;
    });
    byId("table").tHead.replaceChildren(head);
    byId("table").tBodies[0].replaceChildren(...rows);
  };

  const compared = () => {
    const section = byId("comparisons");
    section.hidden = chart.comparisons.length === 0;
    const [head, body] = [section.querySelector("thead"), section.querySelector("tbody")];
    const titles = ["scene", "method", "against", "cost", "cost at equal PSNR", "PSNR at equal cost"];
    head.append(make("tr"));
    titles.forEach((text, i) => head.firstChild.append(make("th", { class: i < 4 ? "text" : "" }, text)));
    const signed = (value, unit) => (value === null ? "none in common"
      : `${value > 0 ? "+" : ""}${value.toFixed(2)} ${unit}`);
    for (const c of chart.comparisons) {
      const row = make("tr");
      for (const text of [c.group, c.method, c.anchor, units[c.cost]]) {
        row.append(make("td", { class: "text" }, text));
      }
      row.append(make("td", {}, signed(c.bd_rate, "%")), make("td", {}, signed(c.bd_psnr, "dB")));
      body.append(row);
    }
  };

  const { machine, program, protocol } = chart;
  byId("machine").textContent = [machine.cpu, `${machine.threads} threads`, machine.simd,
    `pocketnerf ${program.version}`].filter(Boolean).join(" · ");
  describe(byId("provenance"), [
    ["command", protocol.command],
    ["commit", program.commit],
    ["processor", machine.cpu],
    ["system", machine.system],
    ["peak, GFLOP/s", machine.peak_gflops],
    ["peak, GB/s", machine.peak_gb_per_s],
    ["interleaved rounds", protocol.rounds],
    ["times are", "medians over rounds, with 95 % bootstrap intervals, each turn divided by "
      + "how much longer a fixed piece of work took around it than at its best"],
    ["that was, typically", `${protocol.slowdown.toFixed(2)} times`],
    ["unsteady above", `${100 * protocol.unsteady_above} % between the quartiles`],
    ["LPIPS", protocol.lpips],
    ["measured", new Date(1000 * protocol.measured_at).toISOString()],
  ]);
  for (const id of ["group", "x", "y"]) byId(id).addEventListener("change", show);
  compared();
  show();
})();
