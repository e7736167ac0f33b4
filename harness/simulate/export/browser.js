"use strict";
const data = JSON.parse(document.getElementById("data").textContent);
const COLOURS = ["#0a5fb4", "#c4500c", "#3a7d34", "#7b3fa0"], PATIENCE = 60000; // ms
const make = (tag, fields = {}, ...inside) => {
  const one = Object.assign(document.createElement(tag), fields);
  one.append(...inside);
  return one;
};

/* Stops run in a worker; one that does not answer is ended and replaced. */
let worker, number = 0;
const calls = new Map();
function request(content) {
  return new Promise((done, failed) => {
    const id = number++, end = setTimeout(() => drop(`no result after ${PATIENCE / 1000} s`), PATIENCE);
    calls.set(id, { done, failed, end });
    worker.postMessage({ id, ...content });
  });
}
function drop(reason) {
  worker?.terminate();
  worker = null;
  for (const { failed, end } of calls.values()) clearTimeout(end), failed(new Error(reason));
  calls.clear();
}
function start() {
  const code = document.getElementById("worker").textContent;
  worker = new Worker(URL.createObjectURL(new Blob([code], { type: "text/javascript" })));
  worker.onerror = (event) => drop(event.message || "the browser does not start the stop");
  worker.onmessage = ({ data: { id, error, stops } }) => {
    const { done, failed, end } = calls.get(id);
    clearTimeout(end), calls.delete(id);
    if (!error) return done(stops);
    failed(new Error(error));
    drop(error); // after a trap, the memory of the module may be in any state
  };
  worker.postMessage({ data, module: document.getElementById("module").textContent });
}
globalThis.runStops = async (settings) => {
  if (!worker) start();
  return request({ settings });
};
try { start(); } catch { /* the first stop tries again */ } // decodes the module while the controls are made

/* Controls: `settings` has the values in SI units. */
const settings = { controls: {}, laws: {}, shown: data.laws.map((law) => law.kind).slice(0, 3) };
const form = document.getElementById("controls");
const shortest = (value) => String(+value.toPrecision(4));
function slider(name, unit, factor, first, low, high, change, title = "") {
  const shown = make("output"), step = (high - low) / 200;
  const input = make("input", { type: "range", title, min: low, max: high, step: "any", value: first });
  const write = (value) => (shown.value = `${shortest(value * factor)} ${unit === "1" ? "" : unit}`);
  input.oninput = () => write(change(Math.abs(input.value - first) < step ? first : +input.value));
  input.onkeydown = (event) => { // steps of a slider without fixed steps
    const way = { ArrowRight: 1, ArrowUp: 1, ArrowLeft: -1, ArrowDown: -1, PageUp: 10, PageDown: -10 }[event.key];
    if (!way) return;
    event.preventDefault();
    input.value = +input.value + 2 * way * step;
    input.oninput();
  };
  input.reset = () => { input.value = first; write(change(first)); };
  write(first);
  return make("label", {}, name, shown, input);
}
for (const { name, unit, factor, start: first, low, high } of data.controls)
  form.append(slider(name, unit, factor, first, low, high, (value) => (update(), settings.controls[name] = value)));
const laws = make("div", { id: "laws" }, make("h2", { textContent: "Laws" }));
data.laws.forEach(({ kind }, k) => {
  const box = make("input", { type: "checkbox", checked: true });
  box.onchange = () => {
    settings.shown = data.laws.map((law) => law.kind).filter((law) => law === kind ? box.checked : settings.shown.includes(law));
    update();
  };
  const line = make("span", { className: "line" });
  line.style.background = COLOURS[k];
  laws.append(make("label", {}, box, " ", line, kind));
});
form.append(laws);
for (const { kind, thresholds } of data.laws) {
  if (!thresholds.length) continue;
  settings.laws[kind] = {};
  const rows = thresholds.map(({ name, unit, meaning, start: first }) =>
    slider(name, unit, 1, first, 0.5 * first, 2 * first, (value) => (update(), settings.laws[kind][name] = value), meaning));
  form.append(make("details", {}, make("summary", { textContent: `Parameters of ${kind}` }), ...rows));
}
const back = make("button", { textContent: "Back to the scenario" });
back.onclick = () => form.querySelectorAll("input[type=range]").forEach((input) => input.reset());
form.append(back);

/* Laws whose parameters are in an order that they refuse. */
function problems() {
  return data.laws.filter(({ kind }) => settings.shown.includes(kind)).flatMap(({ kind, thresholds }) => {
    const value = (name) => settings.laws[kind]?.[name] ?? thresholds.find((one) => one.name === name).start;
    return thresholds.flatMap(({ name, below }) => below.filter((other) => value(name) > value(other))
      .map((other) => `${kind}: ${name} must not exceed ${other}; move one of them.`));
  });
}

/* Results. */
let stops = [], chosen = "", isRunning = false, isStale = false, drawnWidth = 0;
const results = document.getElementById("results"), figures = document.getElementById("figures");
async function update() {
  isStale = true;
  if (isRunning) return;
  isRunning = true;
  while (isStale) {
    isStale = false;
    await null; // the value that caused this update is set now
    const wrong = problems();
    try {
      if (wrong.length) {
        results.replaceChildren(...wrong.map((text) => make("p", { className: "bad", textContent: text })));
        stops = [], draw();
      }
      for (const kind of wrong.length ? [] : settings.shown) {
        const found = await runStops({ ...settings, shown: [kind] });
        const others = stops.filter((stop) => stop.kind !== kind);
        stops = settings.shown.flatMap((one) => [...found, ...others].filter((stop) => stop.kind === one));
        show();
        if (isStale) break;
      }
      if (!settings.shown.length) stops = [], show();
    } catch (problem) {
      results.replaceChildren(make("p", { className: "bad", textContent:
        `The stop cannot run here: ${problem.message}. Move a slider to try again, or use railgrip itself.` }));
    }
  }
  isRunning = false;
}
const last = (stop, name, index = 0) => stop.rows[stop.rows.length - data.width + data.columns[name][0] + index];
const SENTENCES = {
  horizon: (stop) => `still moving at ${(3.6 * last(stop, "speed")).toFixed(1)} km/h at the end of the horizon`,
  implausible: () => "the plant's outputs are physically impossible", diverged: () => "the estimator diverged",
  plant_failed: (stop) => `the plant failed${stop.message ? `: ${stop.message}` : ""}`,
  controller_failed: () => "the law's command is not a number",
};
function show() {
  const rows = stops.map((stop) => {
    const line = make("span", { className: "line" }), ended = stop.end === "standstill";
    line.style.background = colour(stop.kind);
    const cells = ended ? [`${last(stop, "distance").toFixed(2)} m`, `${stop.time.toFixed(2)} s`] : [];
    const where = !ended && stop.rows.length ? `, after ${last(stop, "distance").toFixed(1)} m and ${stop.time.toFixed(2)} s` : "";
    const sentence = make("td", { className: "sentence bad", colSpan: 2, textContent: ended ? "" : SENTENCES[stop.end](stop) + where });
    return make("tr", {}, make("td", {}, line, stop.kind), ...(ended ? cells.map((text) => make("td", { textContent: text })) : [sentence]));
  });
  const head = make("tr", {}, ...["law", "distance", "duration"].map((text) => make("th", { textContent: text })));
  results.replaceChildren(make("table", {}, head, ...rows));
  if (!stops.some((stop) => stop.kind === chosen)) chosen = stops[0]?.kind ?? "";
  requestAnimationFrame(() => setTimeout(draw)); // the distances are visible before the figures are drawn
}
const colour = (kind) => COLOURS[data.laws.findIndex((law) => law.kind === kind)];

/* Figures. */
const points = (stop, x, y) => {
  const count = stop.rows.length / data.width, every = Math.max(1, Math.floor(count / 1200)), line = [];
  for (let k = 0; k < count; k += every) {
    const at = (name, index = 0) => stop.rows[k * data.width + data.columns[name][0] + index];
    line.push([x(at, k), y(at)]);
  }
  return line;
};
function figure(title, xTitle, lines, { top, log = false, marks = [] } = {}) {
  const width = Math.max(300, figures.clientWidth), height = 230, left = 48, bottom = 34;
  const all = lines.flatMap((line) => line.points).filter(([, y]) => Number.isFinite(y) && (!log || y > 0));
  const xMost = Math.max(1e-9, ...lines.map((line) => line.points.at(-1)?.[0] ?? 0));
  let [low, high] = log ? [0.1, 10] : [0, top ?? all.reduce((most, [, y]) => Math.max(most, y), 1e-9) * 1.05];
  if (log) for (const [, y] of all) low = Math.max(0.01, Math.min(low, y)), high = Math.min(100, Math.max(high, y));
  const scale = log ? (y) => Math.log(Math.max(low, Math.min(high, y)) / low) / Math.log(high / low) : (y) => (y - low) / (high - low);
  const px = (x) => left + (x / xMost) * (width - left - 12), py = (y) => height - bottom - scale(y) * (height - bottom - 8);
  const ticks = (most, count) => {
    const rough = most / count, power = 10 ** Math.floor(Math.log10(rough)), step = [1, 2, 2.5, 5, 10].find((one) => one * power >= rough) * power;
    return Array.from({ length: Math.floor(most / step + 1e-9) + 1 }, (_, k) => +(k * step).toPrecision(6));
  };
  const yTicks = log ? [0.01, 0.1, 1, 10, 100].filter((y) => y >= low && y <= high) : ticks(high, 4);
  const paths = lines.map(({ points: line, colour: stroke, dash = "", label }) => {
    const d = line.filter(([, y]) => Number.isFinite(y)).map(([x, y], k) => `${k ? "L" : "M"}${px(x).toFixed(1)} ${py(y).toFixed(1)}`).join("");
    return `<path d="${d}" fill="none" stroke="${stroke}" stroke-width="1.5" stroke-dasharray="${dash}"><title>${label}</title></path>`;
  });
  const svg = `<svg viewBox="0 0 ${width} ${height}" role="img" aria-label="${title}">`
    + yTicks.map((y) => `<path d="M${left} ${py(y)}H${width - 12}" stroke="#ddd"/><text x="${left - 6}" y="${py(y) + 4}" text-anchor="end">${y}</text>`).join("")
    + ticks(xMost, width < 500 ? 4 : 8).map((x) => `<text x="${px(x)}" y="${height - bottom + 16}" text-anchor="middle">${x}</text>`).join("")
    + marks.map((y) => `<path d="M${left} ${py(y)}H${width - 12}" stroke="#555" stroke-dasharray="5 4"/>`).join("")
    + paths.join("") + `<text x="${width - 12}" y="${height - 4}" text-anchor="end">${xTitle}</text></svg>`;
  const legend = make("div", { className: "legend" }, ...lines.map(({ label, colour: stroke }) => {
    const line = make("span", { className: "line" });
    line.style.background = stroke;
    return make("span", {}, line, label);
  }));
  const one = make("figure", {}, make("figcaption", { textContent: title }), legend);
  one.insertAdjacentHTML("beforeend", svg);
  return one;
}
function draw() {
  drawnWidth = innerWidth;
  const stop = stops.find((one) => one.kind === chosen), shades = ["#0a5fb4", "#c4500c", "#3a7d34", "#7b3fa0", "#997000", "#00838f", "#ad1457", "#555"];
  if (!stop) return figures.replaceChildren();
  const time = (_, k) => Math.min(k * data.stride * data.period, stop.time), { columns } = data, groups = data.first.length;
  const listed = Array.from({ length: groups }, (_, g) => g);
  const of = (name, value) => columns[name] ? listed.map((g) => ({ label: `group ${g + 1}`, colour: shades[g % shades.length], points: points(stop, time, (at) => value(at, g)) })) : [];
  const choice = make("select", { ariaLabel: "Law of the figures" }, ...stops.map(({ kind }) => make("option", { textContent: kind, selected: kind === chosen })));
  choice.onchange = () => { chosen = choice.value; draw(); };
  const speeds = stops.map((one) => ({ label: one.kind, colour: colour(one.kind),
    points: points(one, (at) => at("distance"), (at) => 3.6 * at("speed")) }));
  const ratio = listed.map((g) => ({ label: `group ${g + 1}`, colour: shades[g % shades.length], points: stop.peaks.map(([k, peaks]) =>
    [time(null, k), stop.rows[k * data.width + columns.slip[0] + g] / peaks[g]]) }));
  const train = { label: "train", colour: "#000", points: points(stop, time, (at) => 3.6 * at("speed")) };
  const drawn = [
    figure("Speed of the train [km/h]", "distance [m]", speeds),
    figure(`Train and wheels under ${chosen} [km/h]`, "time [s]", [train, ...of("wheelset_speed", (at, g) => 3.6 * data.radius[g] * at("wheelset_speed", g))]),
    ...(ratio[0].points.length ? [figure(`Slip over slip at the peak of the creep curve under ${chosen}; dashed: at the peak`, "time [s]", ratio, { log: true, marks: [1] })] : []),
    figure(`Brake cylinder pressure under ${chosen} [bar]`, "time [s]", of("cylinder_pressure", (at, g) => at("cylinder_pressure", g) / 1e5)),
    figure(`Friction at the first wheelset of each group under ${chosen}, with conditioning and sand [1]`, "time [s]", of("mu0", (at, g) => at("mu0", data.first[g]))),
  ];
  figures.replaceChildren(drawn[0], make("p", { className: "choice" }, "Figures for ", choice), ...drawn.slice(1));
}
addEventListener("resize", () => { if (innerWidth !== drawnWidth) draw(); });
update();
