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

// A figure is drawn as wide as for a paper, or narrower with its letters, so that nothing overlaps that does not in print.
// Its height stays, so that no axis becomes low.
const NARROWEST = 900;
// Below this width, the legend of the signals is drawn below them.
const NARROW = 700;
function fit(layout, available) {
  if (layout.meta.train) {  // panels below each other fit any width
    layout.width = available;
    if (available >= NARROW) return;
    layout.legend = { ...layout.legend, orientation: "h", x: 0, y: -0.06, yanchor: "top" };
    layout.margin = { ...layout.margin, l: 50 };
    layout.height += 80;
    return;
  }
  const width = Math.max(Math.min(NARROWEST, layout.meta.width), available);
  const share = Math.min(1, width / (layout.meta.width ?? width));
  layout.width = Math.min(width, layout.meta.width ?? width);
  layout.margin.r *= share;
  layout.font = { size: 12 * share };
  const texts = [...layout.annotations ?? [], ...Object.keys(layout).filter((key) => key.startsWith("legend")).map((key) => layout[key])];
  for (const one of texts) {
    if (one.font?.size) one.font.size *= share;
    if (one.entrywidth) one.entrywidth *= share;
  }
}

async function draw() {
  const plots = JSON.parse(await unpacked("plots"));
  const script = document.createElement("script");
  script.textContent = await unpacked("plotly");
  document.head.append(script);
  for (const place of document.querySelectorAll(".plot")) {
    const drawn = plots[place.dataset.plot];
    const { data, layout } = place.clientWidth < NARROWEST && drawn.narrow ? drawn.narrow : drawn;
    if (layout.meta.train) for (const line of data) line.x = layout.meta.train.time;
    if (layout === drawn.narrow?.layout) place.onPaper = structuredClone(drawn);
    fit(layout, place.clientWidth);
    await Plotly.newPlot(place, data, layout, { displaylogo: false });
    if (layout.meta.train) train(place, layout.meta.train);
  }
  document.body.dataset.drawn = "yes";
}
if (document.getElementById("plots")) draw();

// Paper: everything is open, and figures fit on an upright page of A4 between its margins; wide tables have pages across.
const PAPER = { width: 690, height: 1000 };
// The rules of paper, which are applied to the screen while text above a figure is measured.
const printed = [...document.styleSheets[0].cssRules].find((rule) => rule.media?.mediaText === "print");
addEventListener("beforeprint", () => {
  for (const one of document.querySelectorAll("details:not([open])")) { one.open = true; one.dataset.closed = "yes"; }
  for (const one of document.querySelectorAll(".plot")) {
    if (!one.layout) continue;
    if (one.onPaper) {
      one.onScreen = { data: one.data, layout: one.layout };
      const { data, layout } = one.onPaper;
      fit(layout, PAPER.width);
      Plotly.react(one, data, layout);
    }
    const { width, height, meta } = one.layout;
    document.body.style.width = `${PAPER.width}px`;  // text above it is as wide as paper, not as the screen
    printed.media.mediaText = "all";
    const above = one.closest(".summary") ? one.offsetTop : 0;  // on the first page, below the answer
    printed.media.mediaText = "print";
    document.body.style.width = "";
    const free = PAPER.height - above - 40;  // room for the caption
    if (meta.train) {
      one.dataset.size = JSON.stringify({ width, height });
      Plotly.relayout(one, { width: PAPER.width, height: Math.min(height, free) });
    } else {
      // A figure that would become too small below the answer has the next page.
      const here = Math.min(PAPER.width / width, free / height), next = Math.min(PAPER.width / width, (PAPER.height - 40) / height);
      one.style.zoom = here > 0.6 * next ? here : next;
    }
  }
});
addEventListener("afterprint", () => {
  for (const one of document.querySelectorAll("details[data-closed]")) one.open = false;
  for (const one of document.querySelectorAll(".plot")) {
    one.style.zoom = "";
    if (one.onScreen) Plotly.react(one, one.onScreen.data, one.onScreen.layout);
    if (one.dataset.size) Plotly.relayout(one, JSON.parse(one.dataset.size));
  }
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
