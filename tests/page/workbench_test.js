// SPDX-License-Identifier: MIT
//
// node workbench_test.js FOLDER ADDRESS SCENE: drives the workbench of a server at ADDRESS that holds
// SCENE, a file in FOLDER, and compares what it says with what the program says of the same rays.
"use strict";
const fs = require("fs");
const path = require("path");
const { GRAPHICS, check, counted, differing, drag, finish, folder, launch, open, picture, pixels, raymap, said, settle, statistics } = require("./driver");

const [, , , address, sceneFile] = process.argv;
const RAYS = 20000;
const file = () => fs.readFileSync(path.join(folder, sceneFile), "utf8");
const live = (page) => page.evaluate(() => raymap.live());
const number = (text) => Number(text.replace(/,/g, "").replace(/\u2212/g, "-"));

/* The same rays, traced by the program. */
function traced(scene) {
  raymap("trace", scene, "-o", "same.raymap", "-n", String(RAYS), "--force", "--quiet");
  return JSON.parse(raymap("detector", "same.raymap", "sensor", "--json", "--quiet"));
}

const editor = (page, place) => ({
  set: (text) => page.evaluate(([at, value]) => document.querySelector(`${at} .CodeMirror`).CodeMirror.setValue(value), [place, text]),
  get: () => page.evaluate((at) => document.querySelector(`${at} .CodeMirror`).CodeMirror.getValue(), place),
  mistakes: () => page.locator(`${place} .mistake`).allTextContents(),
});

async function until(page, what, call, words) {
  await page.waitForFunction(call, words, { timeout: 20000 }).catch(() => check(false, `not in 20 s: ${what}`));
}

async function isGuarded(page) {
  const answer = await page.request.get(new URL("/", address).href);
  const policy = answer.headers()["content-security-policy"] || "";
  check(/default-src 'none'/.test(policy) && /script-src 'self'/.test(policy) && !/unsafe/.test(policy), `the policy is strict: ${policy}`);
  await page.evaluate(() => document.body.append(Object.assign(document.createElement("script"), { textContent: "window.intruder = 1" })));
  check((await page.evaluate(() => window.intruder)) === undefined, "no script of another's runs");
  said.splice(0, said.length, ...said.filter((line) => !/Content Security Policy/.test(line)));
}

/* Pictures while rays come in; at the end the flux and its error are those of the same rays. */
async function traces(page) {
  const before = (await live(page)).pictures.length;
  await page.fill("#trace-rays", String(RAYS));
  await page.click("#trace-start");
  await until(page, "the trace is done", (n) => raymap.live().state === "done" && raymap.live().traced === n, RAYS);
  await until(page, "a picture of all", (n) => raymap.live().pictures.length > n, before);
  const { flux } = traced(sceneFile);
  await until(page, "the flux of all rays", (text) => document.getElementById("image-note").textContent.includes(text), flux.total.toPrecision(4).replace(/0+$/, ""));
  const told = /flux ([\d.e-]+) ± ([\d.e-]+)/.exec((await page.textContent("#image-note")) || "") || [];
  check(Math.abs(Number(told[1]) / flux.total - 1) < 1e-4, `flux ${told[1]}, the program says ${flux.total}`);
  check(Math.abs(Number(told[2]) / flux.standard_error - 1) < 0.06, `error ${told[2]}, the program says ${flux.standard_error}`);
  check(/ ± /.test(await page.textContent("#live")), "the small picture says the error");
  check((await statistics(page)).rays === 400, "400 rays are drawn");
  await page.fill("#trace-rays", "3000000");
  await page.locator("#canvas").focus();
  await page.keyboard.press("r");
  await until(page, "three pictures of a trace that goes on", (n) => raymap.live().pictures.length > n + 3, (await live(page)).pictures.length);
  await page.keyboard.press("r");
  await until(page, "paused", () => raymap.live().state === "paused");
  const { traced: held, pictures } = await live(page);
  const gaps = pictures.slice(-3).map((at, k, all) => (k ? at - all[k - 1] : 0)).slice(1);
  check(Math.min(...gaps) < 1500, `pictures come every ${gaps.map(Math.round).join(", ")} ms`);
  await picture(page, "running.png");
  await page.keyboard.press("r");
  await until(page, "more rays", (n) => raymap.live().traced > n, held);
  await page.click("#trace-stop");
  await until(page, "stopped", () => raymap.live().state === "stopped");
  await page.fill("#trace-rays", String(RAYS));
  await page.click("#trace-start");
  await until(page, "traced again", (n) => raymap.live().state === "done" && raymap.live().traced === n, RAYS);
  await until(page, "the image of all rays again", (f) => Math.abs(Number(/flux ([\d.e-]+)/.exec(document.getElementById("image-note").textContent)[1]) / f - 1) < 1e-4, flux.total);
}

async function asksCriteria(page) {
  const criterion = editor(page, "#criterion");
  await page.locator("#canvas").focus();
  await page.keyboard.press("e");
  await page.keyboard.type("hit(le");
  await page.waitForSelector(".CodeMirror-hints");
  check((await page.locator(".CodeMirror-hint").allTextContents()).includes("lens.1"), "names are offered");
  await page.keyboard.press("Enter");
  check(/^hit\(lens/.test(await criterion.get()), `a name was taken: ${await criterion.get()}`);
  await criterion.set("segments > 2 and hit(lnes.1)");
  await page.waitForSelector("#criterion .mistake");
  check((await criterion.mistakes()).join() === "lnes.1", `the mistake is marked: ${await criterion.mistakes()}`);
  check(/lens/.test(await page.textContent("#criterion-said")), `and told: ${await page.textContent("#criterion-said")}`);
  await picture(page, "mistake.png");
  const before = await pixels(page, "#canvas");
  for (const [k, text] of ["hit(lens.2, reflect)", "registered(sensor) and not hit(lens)"].entries()) {
    await criterion.set(text);
    await page.click("#criterion-add");
    await until(page, `${text} shown`, (n) => document.querySelectorAll("#where li").length === n, k + 1);
    const told = number((await page.textContent("#criterion-said")).split(" of ")[0]);
    check(told === counted("same.raymap", text), `${told} rays of ${text}`);
  }
  await settle(page);
  check((await page.inputValue("#colour")) === "criterion", "rays have the colours of criteria");
  check((await differing(page, before, await pixels(page, "#canvas"))) > 300, "criteria change the picture");
  const both = (await statistics(page)).shown;
  await page.locator("#where input").first().uncheck();
  check((await statistics(page)).shown < both, "a switch hides the rays of one");
  await picture(page, "criteria.png");
  await page.locator('#where [aria-label^="take away"]').first().click();
  await until(page, "one left", () => document.querySelectorAll("#where li").length === 1);
  await page.evaluate(() => (document.getElementById("ray-box").open = true));
  await page.fill("#ray-id", String(RAYS - 1));
  await page.press("#ray-id", "Enter");
  await until(page, "a ray that was not drawn", (id) => document.getElementById("ray-name").textContent === id && document.querySelector("#ray-report table"), String(RAYS - 1));
  await picture(page, "ray.png");
  await page.click("#criterion-clear");
  await until(page, "none left", () => document.querySelectorAll("#where li").length === 0);
}

/* Sources, detectors and objects stand in one tree: light of a source that is off is left out, a detector is
 * shown, the keys of each are found in the text. */
async function hasTree(page) {
  const objects = page.locator("#objects"), note = () => page.textContent("#image-note");
  check((await objects.locator("> li > label, > li > strong").allTextContents()).join() === "Sources,Detectors,Objects", "the tree's branches");
  const flux = await note();
  await objects.locator("[data-other=lamp]").uncheck();
  await until(page, "no light without the lamp", () => raymap.statistics().rays === 0 && /flux 0 /.test(document.getElementById("image-note").textContent));
  await picture(page, "off.png");
  await page.keyboard.press("Space");
  await until(page, "the lamp's light again", (text) => raymap.statistics().rays === 400 && document.getElementById("image-note").textContent === text, flux);
  await objects.locator("[data-other=far]").check();
  check((await page.inputValue("#detector")) === "1" && (await note()) !== flux, "the other detector is shown");
  await page.keyboard.press("ArrowUp");
  check((await page.inputValue("#detector")) === "0" && (await note()) === flux, "and the first again, by keys");
  for (const [name, key] of [["lamp", "distribution: {cone: 15}"], ["sensor", "name: sensor"], ["lens", "geometry: slab"]]) {
    await page.locator(`[aria-label="move ${name}"]`).first().click();
    await page.locator("#move-text").click();
    const chosen = await page.evaluate(() => document.querySelector("#text .CodeMirror").CodeMirror.getSelection());
    check(chosen.includes(`name: ${name}`) && chosen.includes(key), `the keys of ${name}: ${chosen}`);
    await page.click("#tab-tree");
  }
}

/* Rows of paths, regions, clicked bodies and chosen events become criteria. */
async function clicksCriteria(page) {
  const shown = async (what) => {
    await until(page, `criterion of ${what}`, () => raymap.live().criteria.length === 1 && document.querySelectorAll("#where li").length === 1);
    const [text] = (await live(page)).criteria, told = number(await page.textContent("#where small"));
    check(told > 0 && counted("same.raymap", text) >= told, `${what}: ${text} has ${told} rays here`);
    await page.click("#criterion-clear");
    await until(page, "cleared", () => document.querySelectorAll("#where li").length === 0);
    return text;
  };
  await page.locator("#classes tbody tr[data-class] button").nth(1).click();
  await page.locator("#class-criterion button", { hasText: "show" }).click();
  check(/path\(/.test(await shown("a row of paths")), "a row of paths is a path");
  await page.locator("#image").scrollIntoViewIfNeeded();
  await drag(page, "#image", [0.3, 0.3], [0.7, 0.7]);
  await page.locator("#region-criterion button", { hasText: "show" }).click();
  check(/registered\(sensor, rect\(/.test(await shown("a region")), "a region is a rectangle");
  await page.evaluate(() => raymap.clickBody(0));
  await page.locator("#tip button", { hasText: "reflect" }).click();
  check((await shown("a body")) === "hit(lens.1, reflect)", "a body is clicked");
  await page.evaluate(() => raymap.clickBody(0));
  await page.locator("#canvas").focus();
  await page.keyboard.press("Escape");
  check(await page.locator("#tip").isHidden(), "Esc takes the body's buttons away");
  await page.locator("#steps-box summary").first().click();
  for (const [letter, at] of [["T", "lens.1"], ["T", "lens.2"]]) {
    await page.locator("#letters button", { hasText: new RegExp(`^${letter}$`) }).click();
    await page.selectOption("#step-object", at);
    await page.click("#step-add");
  }
  await page.locator("#steps-criterion button", { hasText: "show" }).click();
  check((await shown("steps")) === 'path("T@lens.1 T@lens.2 .*")', "steps are a path");
  await page.waitForSelector("#tree summary");
  await page.locator("#tree summary").first().click();
  await page.locator("#tree ul button").first().click();
  check(/^source\(lamp\) and path\("/.test(await shown("the tree of events")), "the tree of events");
  await picture(page, "events.png");
}

/* What is not right is said where it was written, and spoils nothing of what is shown. */
async function refusesNonsense(page) {
  for (const wrong of ["1e9", "0", "many"]) {
    await page.fill("#ray-limit", wrong);
    await page.keyboard.press("Tab");
    check((await page.inputValue("#ray-limit")) === "400", `no ${wrong} rays are drawn`);
    check((await page.textContent("#note")).includes(wrong), `${wrong} is refused: ${await page.textContent("#note")}`);
  }
  const criterion = editor(page, "#criterion");
  const counted_ = { rays: { matched: 1, total: 1 }, flux: { matched: 1, standard_error: 0, unit: "W" } };
  await page.route("**/api", (route) => {
    const { id, command } = route.request().postDataJSON();
    if (command === "model") return route.fulfill({ json: { id, ok: false, error: { message: "not for each of them" } } });
    return command === "query" ? route.fulfill({ json: { id, ok: true, result: counted_ } }) : route.continue();
  });
  for (let k = 1; k <= 32; k++) {
    await criterion.set(`ray < ${k}`);
    await page.click("#criterion-add");
    await until(page, `criterion ${k}`, (n) => raymap.live().criteria.length === Math.min(n, 31) && (n < 32 || /is the most/.test(document.getElementById("criterion-said").textContent)), k);
  }
  await page.unroute("**/api");
  await page.click("#criterion-clear");
  await until(page, "cleared", () => document.querySelectorAll("#where li").length === 0 && raymap.live().criteria.length === 0);
  let answer = null;
  const held = new Promise((done) => (answer = done)), isStats = (request) => request.method() === "POST" && request.postDataJSON().command === "stats";
  await page.route("**/api", async (route) => {
    if (isStats(route.request())) await held;
    await route.continue();
  });
  const asked = page.waitForRequest(isStats), answered = page.waitForResponse((response) => isStats(response.request()));
  await page.locator("#canvas").focus();
  await page.keyboard.press("h"); // asks as it opens, and is answered last
  await asked;
  await page.selectOption("#histogram-by", "criterion");
  await page.click("#histogram button");
  const isRefused = () => /no criterion is shown/.test(document.getElementById("histogram-said").textContent);
  await until(page, "no criterion to draw by", isRefused);
  answer();
  await (await answered).finished();
  await settle(page);
  check(await page.evaluate(isRefused), "an answer to what was asked before is not shown");
  await page.unroute("**/api");
  await page.selectOption("#histogram-by", "");
  const words = await page.locator("#numbers option").evaluateAll((all) => all.map((one) => one.value));
  check(words.includes("photon_energy") && words.includes("x(sensor)"), `numbers are offered: ${words}`);
}

/* A question that takes long is told, with how far it is, and can be cancelled. */
async function cancels(page) {
  let asked = null, cancelled = null;
  await page.route("**/api", async (route) => {
    const words = route.request().postDataJSON();
    if (words.command === "paths") asked = words.id;
    if (words.command === "cancel") cancelled = words.of;
    for (let k = 0; words.command === "paths" && k < 100 && cancelled === null; k++) await new Promise((done) => setTimeout(done, 100));
    await route.continue();
  });
  await page.locator("#steps-box").evaluate((box) => (box.open = false));
  await page.locator("#steps-box").evaluate((box) => (box.open = true));
  await page.waitForSelector("#asked:not([hidden])");
  check((await page.textContent("#asked span")) === "paths", "the question that takes long is told");
  await picture(page, "asked.png");
  await page.click("#asked button");
  await page.waitForSelector("#asked", { state: "hidden" });
  check(asked !== null && cancelled === asked && !/^\d+$/.test(asked), `cancelled: ${asked}, ${cancelled}`);
  await page.unroute("**/api");
}

async function drawsHistograms(page) {
  await page.locator("#canvas").focus();
  await page.keyboard.press("h");
  await page.fill("#histogram-of", "path_length");
  await page.keyboard.press("Enter");
  await page.waitForSelector("#histogram-chart .bins");
  await until(page, "the mean", () => /mean/.test(document.getElementById("histogram-said").textContent));
  const { mean } = JSON.parse(raymap("stats", "same.raymap", "--of", "path_length", "--json", "--quiet"));
  const told = /mean ([\d.]+)/.exec(await page.textContent("#histogram-said"))[1];
  check(Math.abs(Number(told) / mean.value - 1) < 1e-5, `mean ${told}, the program says ${mean.value}`);
  await page.fill("#histogram-of", "no_such(sensor)");
  await page.keyboard.press("Enter");
  await page.waitForSelector("#histogram-said.wrong");
  await page.locator("#histogram-chart").scrollIntoViewIfNeeded();
  await picture(page, "histogram.png");
}

/* Text and moves are edits: refused ones change nothing, others are undone, done again and saved. */
async function edits(page) {
  const text = editor(page, "#text"), before = await text.get(), onDisk = file();
  check(before === onDisk, "the editor has the file's text");
  await page.locator("#canvas").focus();
  await page.keyboard.press("t");
  await text.set(before.replace("geometry: wall", "geometry: wal"));
  await page.waitForSelector("#text-mistakes button");
  const line = before.split("\n").findIndex((one) => one.includes("geometry: wall")) + 1;
  check((await page.textContent("#text-mistakes")).startsWith(`${line}:`), `mistake of line ${line}: ${await page.textContent("#text-mistakes")}`);
  await picture(page, "text.png");
  await text.set("");
  await page.click("#text-apply");
  await until(page, "an empty text is refused, without a place", () => /^the text is empty/.test(document.getElementById("text-mistakes").textContent));
  await page.click("#text-revert");
  await until(page, "nothing is wrong with the text before", () => document.getElementById("note").hidden && !document.querySelector("#text-mistakes button"));
  await text.set(before.replace("reflectance: 0.5", "reflectance: 0.25"));
  await page.click("#text-apply");
  await until(page, "the edit", () => !document.getElementById("edit-undo").disabled);
  await page.click("#tab-tree");
  await until(page, "traced anew", (n) => raymap.live().traced === n && raymap.live().state === "done", RAYS);
  await page.locator('[aria-label="move screen"]').click();
  await page.locator("#move-fields input").nth(2).fill("30");
  await page.click("#move-fields button");
  await until(page, "the screen's place in the text", () => /name: screen[^\n]*at: \[0, 0, 70/.test(document.querySelector("#text .CodeMirror").CodeMirror.getValue()));
  await until(page, "all rays of the moved scene", (n) => raymap.live().traced === n && raymap.live().state === "done", RAYS);
  const moved = await text.get();
  check(/reflectance: 0.25/.test(moved), "the edit before it stays");
  fs.writeFileSync(path.join(folder, "moved.yaml"), moved);
  const { flux } = traced("moved.yaml");
  await until(page, `the flux of the moved scene, ${flux.total}`, (f) => Math.abs(Number(/flux ([\d.e-]+)/.exec(document.getElementById("image-note").textContent)[1]) / f - 1) < 1e-4, flux.total);
  check(file() === onDisk, "the file does not yet");
  await picture(page, "moved.png");
  await page.keyboard.press("Escape");
  await text.set(moved + "objects: 5\n");
  await page.locator("#canvas").focus();
  await page.keyboard.press("Control+s");
  await until(page, "a wrong text is told", () => document.querySelector("#text-mistakes button") && !document.getElementById("note").hidden);
  check(file() === onDisk, "a wrong text is not saved");
  const last = moved.replace("reflectance: 0.25", "reflectance: 0.125");
  await text.set(last);
  await page.keyboard.press("Control+s");
  await until(page, "saved", () => document.getElementById("edit-save").disabled);
  check(file() === last, "what is saved is what stands in the editor");
  await page.click("#edit-undo");
  await until(page, "the last undone", (old) => document.querySelector("#text .CodeMirror").CodeMirror.getValue() === old, moved);
  await page.keyboard.press("Control+z");
  await page.waitForFunction(() => !document.getElementById("edit-redo").disabled);
  await page.click("#edit-undo");
  await until(page, "both undone", () => document.getElementById("edit-undo").disabled);
  check((await text.get()) === before, "undone to the first text");
  await until(page, "traced as at first", (n) => raymap.live().traced === n && raymap.live().state === "done", RAYS);
}

/* What one browser changes the other shows; a text that was begun before says that it would take that back. */
async function isShared(page, browser) {
  const other = await open(browser, address, { viewport: { width: 700, height: 700 }, colorScheme: "dark" });
  await other.waitForSelector("html[data-workbench]");
  check((await other.evaluate(() => document.documentElement.scrollWidth)) <= 700, "a narrow window needs no scrolling aside");
  await until(other, "the other has the rays", (n) => raymap.live().traced === n, RAYS);
  const text = editor(page, "#text"), before = await text.get();
  await text.set(before + "# of mine\n");
  await other.locator('[aria-label="move screen"]').click();
  await other.locator("#move-fields input").nth(2).fill("1.5");
  await other.click("#move-fields button");
  await until(page, "both changed", () => /so was the scene/.test(document.getElementById("text-state").textContent));
  await picture(other, "narrow.png");
  await page.click("#tab-text");
  await page.click("#text-revert");
  await until(page, "the other's move", (old) => document.querySelector("#text .CodeMirror").CodeMirror.getValue() !== old, before);
  await page.click("#edit-undo");
  await until(other, "undone for both", (old) => document.querySelector("#text .CodeMirror").CodeMirror.getValue() === old, before);
  await until(page, "traced again", (n) => raymap.live().traced === n && raymap.live().state === "done", RAYS);
  await page.click("#tab-tree");
  await other.context().close();
}

/* What is dragged in the view along x is traced as it goes; all of the drag is one step of undo. Of the scene the server tells
 * nothing but where it is then. */
async function dragsObjects(page) {
  const text = editor(page, "#text"), before = await text.get(), asked = [];
  const note = (request) => asked.push((request.postDataJSON() || {}).parts || "");
  const place = async () => (await page.textContent("#move-place")).replace(/\u2212/g, "-").match(/-?[\d.]+/g).map(Number);
  await page.locator('[aria-label="move lens"]').first().click();
  const first = await place();
  page.on("request", note);
  await page.locator("#canvas").focus();
  await page.keyboard.press("1");
  await page.keyboard.press("m");
  await settle(page);
  const box = await page.locator("#canvas").boundingBox();
  const at = await page.evaluate(() => {
    for (let x = 20; x < 700; x += 5) for (let y = 60; y < 700; y += 5) if (/^lens/.test(raymap.bodyAt(x, y))) return [x + 4, y + 4];
    return null;
  });
  check(at !== null, "the lens is seen");
  await page.mouse.move(box.x + at[0], box.y + at[1]);
  await page.evaluate(() => {
    window.notes = [];
    new MutationObserver(() => window.notes.push(document.getElementById("image-note").textContent)).observe(document.getElementById("image-note"), { childList: true });
  });
  await page.mouse.down();
  for (const up of [40, 80]) {
    const shown = await page.textContent("#image-note"), { pictures } = await live(page);
    await page.mouse.move(box.x + at[0], box.y + at[1] - up, { steps: 4 });
    check(/by 0, [\d.]+, /.test(await page.textContent("#move-place")), `it says how far: ${await page.textContent("#move-place")}`);
    await until(page, "another image while the mouse is down", ([old, n]) => document.getElementById("image-note").textContent !== old && raymap.live().pictures.length > n && raymap.live().traced > 0, [shown, pictures.length]);
  }
  const dark = (await page.evaluate(() => window.notes)).filter((note) => !/flux 0\.\d/.test(note));
  check(dark.length === 0, `no image without light on the way: ${dark}`);
  check((await statistics(page)).rays > 0 && (await text.get()) === before, "the rays follow, the text will");
  check(await page.locator("#tip").isHidden(), "no ray's tip covers what is dragged");
  await picture(page, "dragging.png");
  await page.mouse.up();
  await until(page, "the lens' place in the text", () => /name: lens[^\n]*at: \[0(\.0)?, [\d.]+/.test(document.querySelector("#text .CodeMirror").CodeMirror.getValue()));
  const by = Number(/name: lens[^\n]*at: \[0(?:\.0)?, ([\d.]+)/.exec(await text.get())[1]);
  await until(page, "the lens is shown there", ([y, unit]) => {
    const [, told] = document.getElementById("move-place").textContent.replace(/\u2212/g, "-").match(/-?[\d.]+/g).map(Number);
    return /^about/.test(document.getElementById("move-place").textContent) && Math.abs(told - y) < unit;
  }, [first[1] + by, 1e-3]);
  check((await page.evaluate(([x, y]) => raymap.bodyAt(x, y), [at[0], at[1] - 80])) !== null, "and is picked there");
  await page.click("#edit-undo");
  await until(page, "one undo takes the drag back", (old) => document.querySelector("#text .CodeMirror").CodeMirror.getValue() === old && document.getElementById("edit-undo").disabled, before);
  await until(page, "the lens is shown where it was", (y) => Number(document.getElementById("move-place").textContent.replace(/\u2212/g, "-").match(/-?[\d.]+/g)[1]) === y, first[1]);
  page.off("request", note);
  check(asked.some((parts) => /rays/.test(parts)) && !asked.some((parts) => /scene/.test(parts)), `asked for: ${[...new Set(asked)].join("; ")}`);
  const lamp = await page.evaluate(() => ["left", "top"].map((side) => parseFloat(document.querySelector("#labels .source").style[side])));
  check((await page.evaluate(([x, y]) => raymap.moverAt(x, y), lamp)) === "lamp", "a source is grabbed");
  await page.mouse.move(box.x + lamp[0], box.y + lamp[1]);
  await page.mouse.down();
  await page.mouse.move(box.x + lamp[0], box.y + lamp[1] - 40, { steps: 2 });
  await page.locator("#canvas").focus();
  await page.keyboard.press("Escape");
  await page.mouse.up();
  await until(page, "a drag that Esc ends is no step", () => document.getElementById("edit-undo").disabled && raymap.live().state === "done");
  check((await text.get()) === before, "nor a change");
  await page.keyboard.press("m");
}

/* A unit as long as scenes in photons have it covers no number of the axis. */
async function unitHasRoom(page) {
  const covered = await page.evaluate(() => {
    const drawn = [], kind = CanvasRenderingContext2D.prototype, { fillText } = kind;
    kind.fillText = function (text, x, y, most = Infinity) {
      const long = text.replace(/^W\/.*/, "photons/m\u00b2"), wide = Math.min(this.measureText(long).width, most);
      const left = x - wide * { left: 0, center: 0.5, right: 1 }[this.textAlign];
      drawn.push({ long, y, left, right: left + wide });
    };
    document.getElementById("log").click();
    kind.fillText = fillText;
    document.getElementById("log").click();
    const unit = drawn.find(({ long }) => /^photons/.test(long));
    return unit ? drawn.filter((one) => one !== unit && one.y === unit.y && one.right > unit.left).map(({ long }) => long) : ["no unit"];
  });
  check(covered.length === 0, `the unit of an image covers: ${covered.join(" ")}`);
}

/* The button that moves an object stands in its row, however long the name is. */
async function moversStandInTheirRows(page) {
  const [above, below] = await page.evaluate(() => {
    const row = document.querySelector("#objects .mover").parentElement, name = row.querySelector("label");
    const written = name.innerHTML;
    name.append(" and so on".repeat(19));
    const [label, mover] = [name, row.querySelector(".mover")].map((one) => one.getBoundingClientRect());
    name.innerHTML = written;
    return [label.top - mover.top, mover.bottom - label.bottom];
  });
  check(above < 9 && below < 9, `the button is ${above} px above and ${below} px below its row`);
}

async function isKept(page) {
  const bare = await page.evaluate(() => [...document.querySelectorAll("button, input, select, canvas, textarea")].filter((one) =>
    !(one.getAttribute("aria-label") || one.textContent.trim() || one.closest("label") || one.title || one.ariaHidden)).map((one) => one.outerHTML));
  check(bare.length === 0, `controls without a name: ${bare.join(" ")}`);
  await page.locator("#canvas").focus();
  await page.keyboard.press("?");
  check(/Ctrl\+S/.test(await page.textContent("#keys")), "the help has the workbench's keys");
  await page.locator("#help button").click();
  await until(page, "the dragged scene traced", () => raymap.live().state === "done");
  await page.locator("#trace-rays").focus();
  const order = [];
  for (let k = 0; k < 5; k++) {
    await page.keyboard.press("Tab");
    order.push(await page.evaluate(() => document.activeElement.id));
  }
  check(order[0] === "trace-start" && order.includes("scheme"), `Tab goes on: ${order.join(" ")}`);
}

async function timed(part, page, browser) {
  const begin = Date.now();
  await part(page, browser).catch((error) => check(false, `${part.name}: ${error.message}`));
  console.log(`${part.name}: ${((Date.now() - begin) / 1000).toFixed(1)} s`);
}

async function main() {
  const browser = await launch(...GRAPHICS);
  try {
    const page = await open(browser, address, { viewport: process.env.PICTURES ? { width: 1500, height: 950 } : { width: 1140, height: 700 } });
    await page.waitForSelector("html[data-workbench]", { timeout: 30000 });
    for (const part of [isGuarded, traces, hasTree, asksCriteria, clicksCriteria, refusesNonsense, cancels, drawsHistograms, edits, isShared, dragsObjects, unitHasRoom, isKept, moversStandInTheirRows])
      await timed(part, page, browser);
    await page.click("#scheme");
    await settle(page);
    await picture(page, "dark.png");
    await page.context().close();
  } finally {
    await browser.close();
  }
  finish();
}

main().catch((error) => {
  console.log(`FAILED: ${error.stack}`);
  process.exitCode = 1;
});
