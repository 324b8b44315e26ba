// SPDX-License-Identifier: MIT
//
// The trace and what comes of it: one request for data at a time, no more than two a second.

const PACE = 450; // milliseconds between two pictures
const DRAG_PACE = 100; // while something is dragged
const RAYS_PACE = 3000; // between two sets of rays while they come in
/* wanted: parts, which `coming` brings, behind `pass` that is under way. rays: when they were last asked for; traced: how many there are; wished: how many there are to be.
 * off: names of sources. places: what is elsewhere than it is shown; null: more may be another. revision: of the scene that is shown; heard: of the newest; own: changes by this page that are under way. pictures: when new images were shown. */
const live = { state: "none", wanted: new Set(), coming: null, pass: Promise.resolve(), settled: Promise.resolve(), model: Promise.resolve(), pace: PACE, last: 0, rays: 0, traced: 0, wished: 0, told: 0, first: () => false,
  criteria: [], off: new Set(), places: null, revision: 0, heard: 0, own: 0, pictures: [] };

/* The criterion of the light of the sources that are on; null: all are. */
function lit() {
  const own = scene.sources.map((one) => one.name), off = own.filter((name) => live.off.has(name)), on = own.filter((name) => !live.off.has(name));
  const anyOf = (list) => `(${list.map((name) => `source(${quoted(name)})`).join(" or ")})`;
  return !off.length ? null : !on.length ? NO_RAYS : on.length < off.length ? anyOf(on) : `not ${anyOf(off)}`;
}

/* What is asked of: the criteria that are shown, or all rays, of that light; an empty list: everything. */
function ofWhat() {
  const light = lit();
  return !light ? live.criteria : live.criteria.length ? live.criteria.map((text) => `(${text}) and ${light}`) : [light];
}

/* Asks for parts of the data: "scene", "rays", "detectors"; of several calls the last state is shown. Ends when it is. */
function want(...parts) {
  for (const part of parts) live.wanted.add(part);
  if (!live.coming) live.coming = live.pass = live.pass.then(renewParts);
  return live.coming;
}

/* A change by this page with the first rays of it: in between nothing is asked for, since there are none. The server takes
 * requests of several connections in any order, so it begins when what was asked for is there. */
function settling(call) {
  const done = live.model.then(call);
  live.settled = Promise.allSettled([live.settled, done]);
  return done;
}

/* The scene is that of an answer now. */
function reach({ revision, places }) {
  const follows = live.places && places && revision === live.revision + 1;
  if (revision !== live.revision) live.places = follows ? { ...places, objects: { ...live.places.objects, ...places.objects } } : null;
  live.revision = revision;
}

async function renewParts() {
  const wait = live.last + live.pace - performance.now();
  if (wait > 0 && live.state === "running") await new Promise((done) => setTimeout(done, wait));
  for (let settled = null; settled !== live.settled; await settled) settled = live.settled;
  live.coming = null;
  live.last = performance.now();
  const { criteria, places } = live, where = ofWhat(), isPlaced = live.wanted.has("scene") && places;
  if (isPlaced) live.wanted.delete("scene");
  const parts = [...live.wanted];
  if (parts.includes("scene") || isPlaced) live.places = {};
  live.wanted.clear();
  try {
    const asked = ask("model", { parts: parts.join(","), limit: asking.limit,
      ...(where.length ? { where } : {}), ...(criteria.length ? { color: "criterion" } : {}) });
    live.model = asked.catch(() => {});
    const model = await asked;
    if (model.where) model.where.list.forEach((one, k) => (one.criterion = criteria[k])); // as they were written
    if (isPlaced) takePlaces(places);
    if (parts.includes("rays") || parts.includes("scene")) takeData(model);
    else takeImages(model.detectors.list);
    if (parts.includes("detectors")) live.pictures.push(performance.now());
    say("");
  } catch (refused) {
    if (parts.includes("scene") || isPlaced) live.places = null;
    say(refused.message);
  }
}

/* What went wrong, over the picture. */
function say(text) {
  if (text) note(text);
  else if (!NO_RAY.includes(byId("note").textContent)) note("");
}

/* New images of the same detectors. */
function takeImages(list) {
  data.detectors.list = list;
  detectors.splice(0, detectors.length, ...list);
  forgetPictures();
  if (!current()) return;
  describeDetector();
  drawImage();
  drawLive();
}

/* A small picture of each detector, its flux and the error of that. */
function liveItem(detector, index) {
  const small = element("canvas", { width: 72, height: 54, ariaHidden: "true" });
  const { image: of } = detector;
  if (of) {
    const { cells } = pictureOf(detector, isSpiky(imageValues(detector), of.most)), context = small.getContext("2d");
    const scale = Math.min(72 / cells.width, 54 / cells.height);
    context.imageSmoothingEnabled = false;
    context.drawImage(cells, (72 - scale * cells.width) / 2, (54 - scale * cells.height) / 2, scale * cells.width, scale * cells.height);
  }
  const part = of && of.flux > 0 ? ` (${figure((100 * of.flux_error) / of.flux, 2)} %)` : "";
  const button = element("button", { type: "button" }, small, element("strong", { textContent: detector.name }),
    element("small", { textContent: of && !of.registrations ? "no light" : of ? `${figure(of.flux, 4)} ± ${figure(of.flux_error, 2)} ${scene.flux_unit}${part}` : "" }));
  button.setAttribute("aria-pressed", String(index === sensor.index));
  button.addEventListener("click", () => takeStep({ index, region: null }));
  return element("li", {}, button);
}

function drawLive() {
  const at = [...byId("live").children].findIndex((item) => item.contains(document.activeElement));
  byId("live").replaceChildren(...detectors.map(liveItem));
  if (at >= 0 && byId("live").children[at]) byId("live").children[at].firstChild.focus();
  markDetector();
}
byId("detector-box").querySelector("summary").after(byId("live"));
whenData(drawLive);
byId("detector").addEventListener("change", drawLive);
byId("live").addEventListener("click", drawLive);

/* What the buttons do and the line says in each state of the trace. */
function showTrace({ state, rays, of, message }) {
  const before = live.state;
  live.state = state;
  live.traced = rays;
  if (rays > 0 || of > 0) live.wished = state === "stopped" || state === "failed" ? rays : of;
  const running = state === "running", paused = state === "paused";
  if (running && before !== "running") live.rays = performance.now() - RAYS_PACE + 2 * PACE; // the picture first
  byId("trace-start").disabled = running || paused;
  byId("trace-pause").disabled = !running && !paused;
  byId("trace-pause").textContent = paused ? "go on" : "pause";
  byId("trace-stop").disabled = !running && !paused;
  byId("trace-progress").value = of > 0 ? rays / of : 0;
  byId("trace-state").textContent = message || (rays > 0 || running ? `${whole(rays)} of ${whole(of)} rays${{ running: "", paused: ", paused", stopped: ", stopped", failed: ", failed" }[state] || ""}` : "nothing traced");
  const isFirst = live.heard >= live.revision && (rays > 0 || !running) && live.first();
  const raysToo = isFirst || performance.now() - live.rays > RAYS_PACE;
  if (running && raysToo) live.rays = performance.now();
  if (running && rays > 0) want("detectors", ...(raysToo ? ["rays"] : []));
  else if (before !== state && rays > 0) want("rays", "detectors");
}

/* Events tell the state from then on: an answer may come behind the event that follows it. */
async function trace(action) {
  const rays = Number(byId("trace-rays").value.replace(/[ ,_]/g, ""));
  if (action === "start" && !(Number.isInteger(rays) && rays > 0))
    return void (byId("trace-state").textContent = `"${byId("trace-rays").value}" is no number of rays`);
  try {
    await ask("trace", action === "start" ? { action, rays } : { action });
  } catch (refused) {
    byId("trace-state").textContent = refused.message;
  }
}

/* As many rays of the scene that is now as there were to be of the one before; ends when the first are asked for. */
async function traceAgain() {
  const { trace: told } = await ask("status"); // others may have begun it
  if (!(live.wished > 0 && told.state === "none")) return;
  live.first();
  const first = new Promise((done) => (live.first = () => {
    live.first = () => false;
    done();
    return true;
  }));
  await ask("trace", { action: "start", rays: live.wished });
  await first;
}

byId("trace").addEventListener("submit", (event) => {
  event.preventDefault();
  trace("start");
});
byId("trace-pause").addEventListener("click", () => trace(live.state === "paused" ? "resume" : "pause"));
byId("trace-stop").addEventListener("click", () => trace("stop"));

/* A question that takes long: which, how far it is, and a way to end it. */
const LONG = 1000; // milliseconds

function showAsked() {
  const [id, one] = [...asking.open].find(([, { begun }]) => performance.now() - begun >= LONG) || [];
  const box = byId("asked"), bar = box.querySelector("progress");
  box.hidden = !id;
  if (!id) return;
  box.dataset.id = id;
  box.querySelector("span").textContent = one.command;
  if (one.progress === null) bar.removeAttribute("value");
  else bar.value = one.progress;
}
asking.told = () => {
  showAsked();
  if (asking.open.size) setTimeout(showAsked, LONG + 10);
};
byId("asked").querySelector("button").addEventListener("click", () =>
  ask("cancel", { of: byId("asked").dataset.id }).catch(({ message }) => say(message)));

const events = new EventSource("/events");
events.addEventListener("message", ({ data: text }) => {
  const told = JSON.parse(text);
  if (told.event === "trace") {
    live.told++;
    showTrace(told);
  }
  if (told.event === "progress" && asking.open.has(told.id)) {
    asking.open.get(told.id).progress = told.progress;
    showAsked();
  }
  if (told.event === "scene") {
    live.heard = told.revision;
    if (live.heard > live.revision) live.first(); // the trace before is over
    catchUp();
  }
});
events.addEventListener("error", () => {
  live.first();
  say("The server does not answer; what is shown stays.");
});
events.addEventListener("open", () => {
  live.first(); // what was told meanwhile is lost
  say("");
});
