"use strict";
// Tables sort by a click on a column and filter by a word. Without a library: a page prints the same table that it shows.
for (const table of document.querySelectorAll("table")) {
  const box = document.createElement("div");
  box.className = table.classList.contains("wide") ? "scroll wide" : "scroll";
  table.before(box);
  box.append(table);
}
for (const table of document.querySelectorAll("table.data")) {
  const body = table.tBodies[0];
  if (body.rows.length < 3 || table.closest(".overview")) continue;  // rows of an overview belong together
  table.classList.add("sortable");
  for (const [column, head] of [...table.tHead.rows[0].cells].entries()) {
    head.onclick = () => {
      const sign = head.ariaSort === "ascending" ? -1 : 1;
      for (const other of table.tHead.rows[0].cells) other.removeAttribute("aria-sort");
      head.ariaSort = sign > 0 ? "ascending" : "descending";
      const key = (row) => row.cells[column].dataset.value ?? row.cells[column].textContent;
      // Empty cells follow in both orders; as a number, an empty text would be 0.
      const text = (a, b) => String(a).localeCompare(String(b), undefined, { numeric: true });
      const order = (a, b) => (a === "") - (b === "") || sign * (a - b || text(a, b));
      body.append(...[...body.rows].sort((a, b) => order(key(a), key(b))));
    };
  }
  if (body.rows.length < 20) continue;
  const filter = Object.assign(document.createElement("input"), { className: "filter", placeholder: "Show rows with …", type: "search" });
  filter.oninput = () => {
    const words = filter.value.toLowerCase().split(/\s+/);
    for (const row of body.rows) row.hidden = !words.every((word) => row.textContent.toLowerCase().includes(word));
  };
  table.parentElement.before(filter);
}

async function unpacked(id) {
  const bytes = Uint8Array.from(atob(document.getElementById(id).textContent), (letter) => letter.charCodeAt(0));
  return new Response(new Blob([bytes]).stream().pipeThrough(new DecompressionStream("gzip"))).text();
}

function numbers({ bdata }) {
  return [...new Float32Array(Uint8Array.from(atob(bdata), (letter) => letter.charCodeAt(0)).buffer)];
}

// Below this width, the legend of the signals is drawn below them.
const NARROW = 700;

async function draw(place) {
  const { data, layout } = JSON.parse(await unpacked("signals")), { train: moving } = layout.meta;
  const script = document.createElement("script");
  script.textContent = await unpacked("plotly");
  document.head.append(script);
  for (const line of data) line.x = moving.time;
  layout.width = place.clientWidth;
  if (layout.width < NARROW) {
    layout.legend = { ...layout.legend, orientation: "h", x: 0, y: -0.06, yanchor: "top" };
    layout.margin.l = 50;
    layout.height += 80;
  }
  await Plotly.newPlot(place, data, layout, { displaylogo: false });
  train(place, moving);
  document.body.dataset.drawn = "yes";
}
const signals = document.querySelector(".plot");
if (signals) draw(signals);

// Paper: everything is open, and figures fit on an upright page of A4 between its margins; wide tables have pages across.
const PAPER = { width: 690, height: 1000 };
// The rules of paper, which are applied to the screen while text above a figure is measured.
const printed = [...document.styleSheets[0].cssRules].find((rule) => rule.media?.mediaText === "print");
addEventListener("beforeprint", () => {
  for (const one of document.querySelectorAll("details:not([open])")) { one.open = true; one.dataset.closed = "yes"; }
  document.body.style.width = `${PAPER.width}px`;  // text above a figure is as wide as paper, not as the screen
  printed.media.mediaText = "all";
  const first = signals ?? document.querySelector(".summary .figure"), free = PAPER.height - 40 - (first?.offsetTop ?? 0);  // room for the caption
  printed.media.mediaText = "print";
  document.body.style.width = "";
  if (signals?.layout) {
    const { width, height } = signals.layout;
    signals.dataset.size = JSON.stringify({ width, height });
    Plotly.relayout(signals, { width: PAPER.width, height: Math.min(height, free) });
  }
  for (const one of document.querySelectorAll(".figure .broad")) {
    // A figure that would become too small below the answer has the next page.
    const share = (height) => Math.min(1, PAPER.width / one.naturalWidth, height / one.naturalHeight), next = share(PAPER.height - 40);
    const here = one.closest(".summary") ? share(free) : next;
    one.dataset.width = one.style.width;
    one.style.width = `${(here > 0.6 * next ? here : next) * one.naturalWidth}px`;
  }
});
addEventListener("afterprint", () => {
  for (const one of document.querySelectorAll("details[data-closed]")) one.open = false;
  for (const one of document.querySelectorAll("img[data-width]")) one.style.width = one.dataset.width;
  if (signals?.dataset.size) Plotly.relayout(signals, JSON.parse(signals.dataset.size));
});

// The train over its signals: axles coloured by slip or adhesion at a cursor that the mouse or a clock moves.
function train(place, { positions, cars, colours, time, distance, signals }) {
  const lines = place.data, x = { time: (time = numbers(time)), distance: (distance = numbers(distance)) };
  for (const one of Object.values(signals)) one.values = one.values.map(numbers);
  const front = Math.min(0, ...cars.flat()), length = Math.max(...positions, ...cars.flat()) - front || 1;
  const box = document.createElement("div");
  box.innerHTML = `<div class="controls"><button>▶ Play</button><input type="range" min="0" max="${time.length - 1}" value="0">
    <label>axles by <select class="by">${Object.keys(signals).map((name) => `<option>${name}</option>`).join("")}</select></label>
    <label>over <select class="over"><option value="time">time</option><option value="distance">distance</option></select></label></div>
    <p class="caption"></p><svg viewBox="-30 14 1060 76" width="100%" style="max-height: 7rem"></svg>`;
  place.before(box);
  const [button, slider, by, over] = ["button", "input", ".by", ".over"].map((name) => box.querySelector(name));
  const svg = box.querySelector("svg"), at = (behind) => (1000 * (behind - front)) / length;
  const radius = Math.min(13, 400 / positions.length);
  svg.innerHTML =
    cars.map(([begin, end]) => `<rect x="${at(begin) + 2}" y="18" width="${at(end) - at(begin) - 4}" height="36" rx="8" fill="#eef2f5" stroke="#777"/>`).join("") +
    `<line x1="-30" x2="1030" y1="${64 + radius}" y2="${64 + radius}" stroke="#777" stroke-width="2"/>` +
    positions.map((behind, k) => `<circle cx="${at(behind)}" cy="64" r="${radius}" stroke="${colours[k]}" stroke-width="4"><title>wheelset ${k + 1}</title></circle>`).join("");
  const wheels = [...svg.querySelectorAll("circle")], text = box.querySelector(".caption");
  const shade = (share, colours) => {
    const place = Math.max(0, Math.min(1, share || 0)) * (colours.length - 1), low = Math.min(Math.floor(place), colours.length - 2);
    return `rgb(${colours[low].map((part, k) => Math.round(part + (place - low) * (colours[low + 1][k] - part)))})`;
  };
  let index = 0;
  const show = (k) => {
    slider.value = index = k;
    const { values, low, high, unit, colours, factor } = signals[by.value];
    for (const [wheelset, wheel] of wheels.entries()) {
      const value = values[wheelset][k];
      wheel.setAttribute("fill", Number.isNaN(value) ? "none" : shade(Math.log(Math.max(value, low) / low) / Math.log(high / low), colours));
      wheel.firstChild.textContent = `wheelset ${wheelset + 1}: ${Number.isNaN(value) ? "–" : (factor * value).toPrecision(3)} ${unit}`;
    }
    const span = [low, high].map((value) => `${+(factor * value).toPrecision(2)}${unit && " " + unit}`).join(" (light) to ");
    text.textContent = `${time[k].toFixed(2)} s, ${distance[k].toFixed(1)} m; ${by.value} from ${span} (dark)`;
    Plotly.relayout(place, { "shapes[0].x0": x[over.value][k], "shapes[0].x1": x[over.value][k] });
  };
  slider.oninput = () => show(+slider.value);
  by.onchange = () => show(index);
  over.onchange = () => {
    Plotly.update(place, { x: lines.map(() => x[over.value]) },
      { "xaxis.autorange": true, "xaxis.title.text": over.value === "time" ? "time since the brake demand [s]" : "distance since the brake demand [m]" });
    show(index);
  };
  place.on("plotly_hover", ({ points: [point] }) => show(point.pointNumber % time.length));
  let started = null;
  const step = (now) => {
    if (started === null) return;
    const seconds = started.from + (now - started.at) / 1000, next = time.findIndex((one) => one >= seconds);
    show(next < 0 ? time.length - 1 : next);
    if (next < 0) started = null; else requestAnimationFrame(step);
    button.textContent = started ? "⏸ Pause" : "▶ Play";
  };
  button.onclick = () => {
    started = started ? null : { from: index >= time.length - 1 ? time[0] : time[index], at: performance.now() };
    button.textContent = started ? "⏸ Pause" : "▶ Play";
    requestAnimationFrame(step);
  };
  show(Math.floor(time.length / 3));
}
