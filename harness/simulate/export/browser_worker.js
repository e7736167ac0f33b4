// Runs stops in WebAssembly, away from the page, which stays responsive.
let api, data, prepared, shape, friction, rows, bases;

async function inflate(text) {
  const packed = Uint8Array.fromBase64?.(text) ?? Uint8Array.from(atob(text), (letter) => letter.charCodeAt(0));
  return new Response(new Blob([packed]).stream().pipeThrough(new DecompressionStream("deflate"))).arrayBuffer();
}

async function prepare(module) {
  const compiled = await WebAssembly.compile(await inflate(module));
  const imports = {};
  for (const { module: from, name } of WebAssembly.Module.imports(compiled)) {
    (imports[from] ??= {})[name] = () => { throw new Error(`the stop calls ${name}, which a page does not have`); };
  }
  api = (await WebAssembly.instantiate(compiled, imports)).exports;
  api._initialize?.();
  shape = place(new BigInt64Array(await inflate(data.rail.shape)));
  api.add_up(shape, data.rail.rows, data.rail.columns);
  friction = allocate(8 * data.rail.recovery.length * data.rail.rows);
  rows = allocate(8 * data.width * (Math.floor(data.samples / data.stride) + 3));
  bases = await Promise.all(data.laws.map(async (law) => new Float64Array(await inflate(law.words))));
}

function allocate(bytes) {
  const at = api.allocate(bytes);
  if (!at) throw new Error("the browser has no memory left for the stop");
  return at;
}

// Copies an array into the module; a view of its memory is valid until the next allocation.
function place(array) {
  const at = allocate(array.byteLength);
  new array.constructor(api.memory.buffer, at, array.length).set(array);
  return at;
}

function words(number, settings) {
  const law = data.laws[number], result = bases[number].slice();
  const step = ([name, power]) => {
    const control = data.controls.find((one) => one.name === name);
    if (!control) return 0; // another law has no formula for it
    const { start } = control, value = settings.controls[name] ?? start;
    const term = (one) => name === "gradient" ? one / Math.sqrt(1 + one * one) : one ** power;
    return term(value) - term(start);
  };
  for (const [terms, entries] of law.fit) {
    const steps = terms.map(step).reduce((product, one) => product * one, 1);
    if (steps) for (const [at, slope] of entries) result[at] += steps * slope;
  }
  for (const { name, place: at } of law.thresholds) result[at] = settings.laws?.[law.kind]?.[name] ?? result[at];
  return result;
}

function run(number, settings) {
  const law = data.laws[number], all = words(number, settings), { rail, width } = data;
  const memory = [], put = (array) => memory[memory.push(place(array)) - 1];
  try {
    const recovery = put(Float64Array.from(rail.recovery)), links = put(Int32Array.from(law.links));
    const image = put(all.slice(0, law.image)), parameters = put(all.slice(law.image));
    const written = put(new Int32Array(1));
    const level = settings.controls.friction ?? rail.level;
    api.lay_rail(friction, shape, rail.rows, rail.columns, level * rail.factor, rail.recovered, recovery);
    const began = performance.now();
    const end = api.run(number, image, links, law.links.length / 2, parameters, data.stride, rows, written);
    const seconds = (performance.now() - began) / 1000;
    const count = new Int32Array(api.memory.buffer, written, 1)[0], time = api.sample(image) * data.period;
    const found = new Float64Array(api.memory.buffer, rows, count * width).slice();
    const text = new Uint8Array(api.memory.buffer, api.plant_message(), 1024);
    const message = new TextDecoder().decode(text.slice(0, text.indexOf(0)));
    return { kind: law.kind, end: data.ends[end] ?? "plant_failed", message, time, seconds, rows: found, peaks: peaks(found) };
  } finally {
    memory.forEach(api.release);
  }
}

// Slip at the peak of the creep curve, for the first wheelset of each group, in at most 250 of the rows.
function peaks(rows) {
  const { columns, width } = data, count = rows.length / width, every = Math.max(1, Math.ceil(count / 250)), result = [];
  if (!columns.wheelset_load) return result;
  for (let k = 0; k < count; k += every) {
    const at = (name, index) => rows[k * width + columns[name][0] + index];
    result.push([k, data.first.map((w) => api.peak(at("speed", 0), at("wheelset_load", w), at("mu0", w)))]);
  }
  return result;
}

onmessage = async ({ data: request }) => {
  if (request.module) {
    data = request.data, prepared = prepare(request.module);
    return;
  }
  try {
    await prepared;
    const shown = data.laws.flatMap(({ kind }, number) => request.settings.shown?.includes(kind) === false ? [] : [number]);
    const stops = shown.map((number) => run(number, request.settings));
    postMessage({ id: request.id, stops }, stops.map((stop) => stop.rows.buffer));
  } catch (problem) {
    postMessage({ id: request.id, error: String(problem.message ?? problem) });
  }
};
