// SPDX-License-Identifier: MIT
//
// node page_test.js FOLDER: drives a real chromium over the pages that test_page.sh wrote there,
// and compares what they say with what the program says.
"use strict";
const path = require("path");
const { pathToFileURL } = require("url");
const { GRAPHICS, check, colours, counted, differing, drag, finish, folder, launch, open: openAddress, picture, pixels, raymap, said, settle, statistics, turnTo: turnToAddress } = require("./driver");

const address = (file) => pathToFileURL(path.join(folder, file)).href;
const open = (browser, file) => openAddress(browser, address(file));
const turnTo = (page, file) => turnToAddress(page, address(file));

/* Pixels that have changed since they were taken. */
const changed = async (page, before) => differing(page, before, await pixels(page, "#canvas"));

async function drawsTheScene(page) {
  const shades = await colours(page, await pixels(page, "#canvas"));
  check(shades > 200, `the canvas shows ${shades} colours`);
  check((await statistics(page)).rays === 400, "the page holds 400 rays");
  check(/400 of/.test(await page.textContent("#about")), "the heading says how many rays");
  await page.locator("#objects-box summary").click();
  const before = await pixels(page, "#canvas");
  await page.locator("#objects input").first().uncheck();
  await settle(page);
  check((await changed(page, before)) > 100, "hiding an object changes the picture");
  await page.locator("#objects input").first().check();
}

/* A processor that draws shows the first rays alone while the scene turns, and all of them at rest. */
async function thinsWhileTurning(page) {
  await page.locator("#canvas").focus();
  await page.keyboard.press("ArrowRight");
  await page.waitForFunction(() => !raymap.statistics().resting && raymap.statistics().drawn < raymap.statistics().strokes, null, { timeout: 5000 });
  await settle(page);
  const { drawn, strokes } = await statistics(page);
  check(drawn === strokes, `${drawn} of ${strokes} segments are drawn at rest`);
}

async function showsClasses(page) {
  const rows = page.locator("#classes tbody tr");
  let sum = 0;
  for (let k = 0; k < (await rows.count()); k++)
    sum += Number((await rows.nth(k).locator("td").nth(1).textContent()).replace(/,/g, ""));
  check(sum === 400, `the classes hold ${sum} of 400 rays`);
  await agreesWithPaths(page, [], "surface");
  const second = rows.nth(1), rays = Number(await second.locator("td").nth(1).textContent());
  const before = await pixels(page, "#canvas");
  await second.locator("button").click();
  await settle(page);
  check((await statistics(page)).shown === rays, `a class of ${rays} rays alone is shown`);
  check((await page.textContent("#shown")) === `${rays} of 400 shown`, "the page says how many are shown");
  check((await changed(page, before)) > 500, "showing one class changes the picture");
  const criterion = await page.textContent("#class-criterion code");
  const ids = await page.evaluate(() => raymap.shown());
  const found = raymap("query", "a.raymap", `(${criterion}) and ray <= ${await page.evaluate(() => raymap.lastRay())}`, "--count", "--json", "--quiet");
  check(JSON.parse(found).rays.matched === ids.length, `the class's criterion finds ${ids.length} rays: ${criterion}`);
  await picture(page, "class.png");
  await second.locator("button").click();
  check((await statistics(page)).shown === 400, "a second click shows all rays again");
}

/* The table is that of `paths`: rays, flux and share of all matching rays, with standard errors. */
async function agreesWithPaths(page, words, by) {
  const told = JSON.parse(raymap("paths", "a.raymap", ...words, "--by", by, "--top", "500", "--json", "--quiet"));
  const rows = page.locator("#classes tbody tr[data-class]");
  check((await rows.count()) === told.classes.length, `${await rows.count()} classes by ${by}, paths has ${told.classes.length}`);
  for (let k = 0; k < Math.min(told.classes.length, 6); k++) {
    const cells = (await rows.nth(k).locator("td").allTextContents()).map((text) => text.replace(/,/g, ""));
    const [, , rays, flux, share] = cells.map((text) => text.replace(/\u2212/g, "-"));
    const own = told.classes[k];
    const [value, error] = flux.split("\u00b1").map(Number);
    check(Number(rays) === own.rays, `rays of class ${k}: ${rays}`);
    check(Math.abs(value / own.flux - 1) < 1e-3 && Math.abs(error / own.standard_error - 1) < 0.06, `flux of class ${k}: ${flux}`);
    check(/^[\d.e-]+ \u00b1 [\d.e-]+ %$/.test(share) && Math.abs(parseFloat(share) / 100 / own.share - 1) < 1e-3, `share of class ${k}: ${share}`);
  }
  check((await page.textContent("#classes-note")).includes(`by ${by}`), "the page says by whose names");
}

async function switchesCriteria(page) {
  await agreesWithPaths(page, ["--where", "(hit(lens.2, reflect)) or (segments > 4 or ray < 60)"], "object");
  check((await page.inputValue("#colour")) === "criterion", "rays are coloured by criterion");
  const boxes = page.locator("#where input");
  check((await boxes.count()) === 2, "a switch for each criterion");
  const both = await pixels(page, "#canvas"), all = (await statistics(page)).shown;
  await picture(page, "criteria.png");
  const last = await page.evaluate(() => raymap.lastRay());
  for (const [k, criterion] of [[1, "hit(lens.2, reflect)"], [0, "segments > 4 or ray < 60"]]) {
    await boxes.nth(k).uncheck();
    await settle(page);
    const left = counted("a.raymap", `(${criterion}) and ray <= ${last}`);
    check((await statistics(page)).shown === left && left > 0 && left < all, `without criterion ${k} ${left} of ${all} rays are shown`);
    check((await changed(page, both)) > 300, "a switch changes the picture");
    await page.locator("#region input").first().scrollIntoViewIfNeeded();
    for (let i = 0; i < 4; i++) await page.locator("#region input").nth(i).fill(["-9", "-9", "9", "9"][i]);
    await page.locator("#region button").click();
    const asked = await page.textContent("#region-criterion code");
    const inside = Number.parseInt((await page.textContent("#region-count")).replace(/,/g, ""), 10);
    check(counted("a.raymap", `(${asked}) and ray <= ${last}`) === inside, `${inside} rays in a region with one switch: ${asked}`);
    await page.locator("#draw-none").click();
    await page.locator("#where").scrollIntoViewIfNeeded();
    check(!(await page.evaluate(() => raymap.hasImage())), "no image with light of what is off");
    await picture(page, `criterion-${k}.png`);
    await boxes.nth(k).check();
  }
  check((await statistics(page)).shown === all, "both switched on again");
  check(await page.evaluate(() => raymap.hasImage()), "and the image with them");
  await settle(page);
  const before = await pixels(page, "#canvas");
  await page.selectOption("#colour", "natural");
  await settle(page);
  check((await changed(page, before)) > 300, "natural colours are others");
  await page.locator("#classes [data-class] button").first().click();
  await page.locator("#image").scrollIntoViewIfNeeded();
  await drag(page, "#image", [0.2, 0.2], [0.8, 0.8]);
  for (const box of ["#class-criterion", "#region-criterion"]) {
    const text = await page.textContent(`${box} code`);
    check(text.split("segments > 4").length === 2, `${box} has the page's criterion once: ${text}`);
    check(box === "#region-criterion" || counted("a.raymap", text) > 0, `${box} finds rays`);
  }
}

async function reportsUnderThePointer(page) {
  const id = await page.evaluate(() => raymap.shown()[7]);
  const report = JSON.parse(raymap("report", "a.raymap", String(id), "--json"));
  const box = await page.locator("#canvas").boundingBox();
  const [x, y] = await page.evaluate((ray) => raymap.middle(ray, 0), id);
  await page.mouse.move(box.x + x, box.y + y);
  await page.waitForSelector("#tip:not([hidden])", { timeout: 5000 }).catch(() => {});
  const tip = await page.textContent("#tip");
  const hit = Number((/ray (\d+), step (\d+)/.exec(tip) || [])[1]);
  check(Number.isInteger(hit), `a leg under the pointer is reported: "${tip}"`);
  for (const word of ["source", "event", "medium", "position", "length", "flux", " mm", " nm"])
    check(tip.includes(word), `the report of a leg says ${word}: "${tip}"`);
  await page.mouse.click(box.x + x, box.y + y);
  check(Number(await page.textContent("#ray-name")) === hit, "a click chooses the ray under the pointer");
  await page.fill("#ray-id", String(id));
  await page.press("#ray-id", "Enter");
  const history = page.locator("#ray-report table").first();
  const steps = history.locator("tbody tr:not(.registration)");
  check((await steps.count()) === report.steps.length, `ray ${id} has ${report.steps.length} steps`);
  for (let k = 0; k < report.steps.length; k++) {
    const text = await steps.nth(k).textContent();
    check(text.includes(report.steps[k].object || "") && report.steps[k].events.every((word) => text.includes(word)),
      `step ${k} of ray ${id} is as in \`report\`: ${text}`);
  }
  const place = (await page.locator("#ray-report table").nth(1).locator("tbody tr").nth(1).textContent()).replace(/\u2212/g, "-");
  check(place.includes(String(Number(report.steps[0].position[2].toPrecision(9)))), `position of step 0: ${place}`);
  check((await history.locator("tr.registration").count()) === report.registrations.length, "registrations are listed");
  await picture(page, "report.png");
  await page.keyboard.press("Escape");
  await page.mouse.move(box.x + 3, box.y + box.height / 2);
}

async function asksForRegions(page) {
  await page.locator("#image").scrollIntoViewIfNeeded();
  for (const [detector, kind, from, to] of [["sensor", "rect", [0.3, 0.25], [0.55, 0.6]],
    ["sensor", "ellipse", [0.3, 0.25], [0.55, 0.6]], ["far", "rect", [0.2, 0.05], [0.5, 0.9]], ["far", "ellipse", [0.2, 0.05], [0.7, 0.9]]]) {
    await page.selectOption("#detector", { label: detector });
    await page.locator(`#draw-${kind}`).click();
    await drag(page, "#image", from, to);
    const criterion = await page.textContent("#region-criterion code");
    check(criterion.startsWith(`registered(${detector}, ${kind}(`), `a ${kind} was drawn: ${criterion}`);
    const told = Number(/^([\d,]+)/.exec(await page.textContent("#region-count"))[1].replace(/,/g, ""));
    const whole = counted("a.raymap", `(${criterion}) and ray <= ${await page.evaluate(() => raymap.lastRay())}`);
    check(told === whole && told > 0 && told < 400, `${criterion}: the page says ${told}, query ${whole}`);
    await picture(page, `${detector}-${kind}.png`);
  }
  await takesNumbersAsQuery(page);
  await page.locator("#draw-none").click();
  check(await page.locator("#region-criterion").isHidden(), "no region, no criterion");
}

/* Corners in any order; what is no number, or no half-axis, is refused. */
async function takesNumbersAsQuery(page) {
  const fields = page.locator("#region input"), last = await page.evaluate(() => raymap.lastRay());
  const take = async (numbers) => {
    for (let k = 0; k < 4; k++) await fields.nth(k).fill(numbers[k]);
    await page.locator("#region button").click();
    return page.textContent("#region-count");
  };
  await page.selectOption("#detector", { label: "sensor" });
  await page.locator("#draw-rect").click();
  const told = await take(["3", "3", "-3", "-3"]), found = counted("a.raymap", `registered(sensor, rect(3, 3, -3, -3)) and ray <= ${last}`);
  check(Number.parseInt(told.replace(/,/g, ""), 10) === found && found > 0, `swapped corners: "${told}", query ${found}`);
  const flux = JSON.parse(raymap("detector", "a.raymap", "sensor", "--json", "--quiet")).flux.total;
  const all = Number((/whole image about ([\d.e-]+)/.exec(await take(["-1e3", "-1e3", "1e3", "1e3"])) || [])[1]);
  check(Math.abs(all / flux - 1) < 1e-3, `a region of all of the image has ${all} of its flux ${flux}`);
  for (const bad of ["", "0x10", "1e400", "two"])
    check(/^Refused/.test(await take([bad, "0", "1", "1"])), `"${bad}" is refused`);
  await page.locator("#draw-ellipse").click();
  check(/must be > 0/.test(await take(["0", "0", "0", "1"])), "a half-axis of 0 is refused");
}

/* Numbers of the region, as its criterion has them. */
const numbersOf = async (page) =>
  /(?:rect|ellipse)\(([^)]*)\)/.exec(await page.textContent("#region-criterion code"))[1].split(",").map(Number);
const near = (a, b, tolerance) => a.every((value, k) => Math.abs(value - b[k]) <= tolerance);

/* A region is moved by its inside, resized by its edges and by keys; every step is undone and done again. */
async function movesRegions(page) {
  await page.locator("#image").scrollIntoViewIfNeeded();
  await page.selectOption("#detector", { label: "sensor" });
  for (const kind of ["rect", "ellipse"]) {
    await page.locator(`#draw-${kind}`).click();
    await drag(page, "#image", [0.3, 0.3], [0.5, 0.5]);
    const first = await numbersOf(page), size = kind === "rect" ? first[2] - first[0] : 2 * first[2];
    await drag(page, "#image", [0.4, 0.4], [0.5, 0.4]);
    const moved = await numbersOf(page), by = moved[0] - first[0], add = kind === "rect" ? [by, 0, by, 0] : [by, 0, 0, 0];
    check(by > 0.4 * size && by < 0.6 * size && near(moved, first.map((v, k) => v + add[k]), 1e-9), `a ${kind} moves by half its width: ${first} to ${moved}`);
    await drag(page, "#image", [0.6, 0.4], [0.8, 0.4]);
    const wider = await numbersOf(page), width = kind === "rect" ? wider[2] - wider[0] : 2 * wider[2];
    check(width > 1.9 * size && width < 2.1 * size, `its edge makes it ${width / size} times as wide: ${wider}`);
    check(kind === "rect" ? near(wider.slice(0, 2), moved.slice(0, 2), 1e-9) && wider[3] === moved[3] : near([wider[1], wider[3]], [moved[1], moved[3]], 1e-9),
      `and leaves the others: ${moved} to ${wider}`);
    await page.locator("#image").focus();
    await page.keyboard.press("ArrowUp");
    await page.keyboard.press("Shift+ArrowRight");
    const keyed = await numbersOf(page);
    check(keyed[1] > wider[1] && keyed[2] > wider[2], `keys move and resize it: ${wider} to ${keyed}`);
    for (const told of [null, wider, moved, first]) {
      await page.keyboard.press(told === moved ? "Control+z" : "z");
      if (told) check(near(await numbersOf(page), told, 0), `undone to ${told}: ${await numbersOf(page)}`);
    }
    await page.locator("#undo").click();
    check(await page.locator("#region-criterion").isHidden(), "undone to no region");
    for (let k = 0; k < 4; k++) await page.keyboard.press("Shift+Z");
    await page.locator("#redo").click();
    check(near(await numbersOf(page), keyed, 0), `done again: ${keyed}`);
    await page.locator("#image").hover({ position: { x: 90, y: 90 } });
    await page.mouse.down();
    await page.keyboard.press("Escape");
    await page.mouse.up();
    check(near(await numbersOf(page), keyed, 0), "Esc drops what the pointer does");
    await turnsRegion(page, kind);
    await page.locator("#draw-none").click();
  }
}

/* By its knob, by keys and in numbers; it is then resized along its own axes. What lies in it is what its criterion finds. */
async function turnsRegion(page, kind) {
  const box = await page.locator("#image").boundingBox(), [x, y] = await page.evaluate(() => raymap.knob());
  await drag(page, "#image", [x / box.width, y / box.height], [x / box.width + 0.2, y / box.height + 0.1]);
  const angle = Number(await page.locator("#region-turn input").inputValue());
  check(angle < -20 && angle > -90, `the knob turns a ${kind} clockwise: ${angle}`);
  await page.keyboard.press("<");
  check(Number(await page.locator("#region-turn input").inputValue()) === angle + 1, "a key turns it back by a degree");
  await page.locator("#region-turn input").fill("30");
  await page.locator("#region button").click();
  await page.locator("#image").focus();
  await page.keyboard.press("Shift+ArrowRight");
  const criterion = await page.textContent("#region-criterion code"), last = await page.evaluate(() => raymap.lastRay());
  check(kind === "rect" ? /polygon\(/.test(criterion) : /, 30 deg\)/.test(criterion), `a turned ${kind}: ${criterion}`);
  const told = Number.parseInt((await page.textContent("#region-count")).replace(/,/g, ""), 10), found = counted("a.raymap", `(${criterion}) and ray <= ${last}`);
  check(told === found && told > 0, `${criterion}: the page says ${told}, query ${found}`);
  await picture(page, `turned-${kind}.png`);
}

/* Rays in the table of classes, by the number of the row. */
const classCounts = (page) => page.locator("#classes tbody tr[data-class]:visible").evaluateAll((rows) =>
  rows.map((row) => [Number(row.dataset.class), Number(row.cells[1].textContent.replace(/,/g, ""))]));

/* A region chooses classes, a class the image and the counts of a region. */
async function filtersOneAnother(page) {
  const last = await page.evaluate(() => raymap.lastRay());
  const all = await classCounts(page);
  await page.locator("#image").scrollIntoViewIfNeeded();
  await page.locator("#draw-rect").click();
  await drag(page, "#image", [0.35, 0.3], [0.5, 0.5]);
  const criterion = await page.textContent("#region-criterion code");
  const inside = await classCounts(page), sum = inside.reduce((n, [, rays]) => n + rays, 0);
  const rest = await page.evaluate(() => Number(document.querySelector("#classes tr.rest")?.cells[1].textContent || 0));
  check(sum + rest === counted("a.raymap", `(${criterion}) and ray <= ${last}`), `${sum} rays of the classes and ${rest} others lie in ${criterion}`);
  check(inside.length < all.length && inside.every(([, rays]) => rays > 0), `${inside.length} of ${all.length} classes have rays there`);
  check((await page.textContent("#classes-filter")).startsWith(`${inside.length} of them`), "and the page says so");
  await picture(page, "filtered.png");
  const [index, rays] = inside[0];
  await page.locator(`#classes tr[data-class="${index}"] button`).click();
  check(!(await page.evaluate(() => raymap.hasImage())), "of a class the image has its rays alone");
  const both = await page.textContent("#region-criterion code");
  check(counted("a.raymap", `(${both}) and ray <= ${last}`) === rays, `${both} finds the class's ${rays} rays`);
  check((await page.textContent("#region-count")).startsWith(`${rays} of`), `the region tells ${rays}`);
  check(JSON.stringify(await classCounts(page)) === JSON.stringify(inside), "the other classes keep their counts");
  await picture(page, "filtered-class.png");
  await page.keyboard.press("Escape");
  check(JSON.stringify(await classCounts(page)) === JSON.stringify(all), "Esc brings all back");
}

async function searchesAndNames(page) {
  await page.locator("#image").scrollIntoViewIfNeeded();
  const box = await page.locator("#image").boundingBox();
  await page.mouse.move(box.x + box.width / 2, box.y + box.height / 2);
  check(/mm: [\d.e]+ W\/m/.test(await page.textContent("#image-value")), "the value under the pointer is told");
  await page.fill("#find-class", "no such class");
  check((await page.locator("#classes [data-class]:visible").count()) === 0, "a search hides the classes without its words");
  await page.fill("#find-class", "");
  const told = await page.evaluate(() => raymap.clickBody(0));
  check(told.length > 0, "a click on a body names it");
  await page.locator("#tip button").click();
  check(!(await page.locator('[data-object="0"]').isChecked()), `and hides it: ${told}`);
  await page.evaluate(() => document.querySelector('[data-object="0"]').click());
  await page.emulateMedia({ media: "print" });
  const height = await page.evaluate(() => document.documentElement.scrollHeight);
  check(height < 4000, `a print is ${height} pixels high`);
  await page.emulateMedia({ media: "screen" });
}

/* A lost context is told of, and the scene is drawn again with the next one. */
async function losesItsContext(page) {
  await page.evaluate(() => {
    const canvas = document.getElementById("canvas"), context = canvas.getContext("webgl") || canvas.getContext("webgl2");
    window.loss = context.getExtension("WEBGL_lose_context");
    loss.loseContext();
  });
  await page.waitForSelector("#note:not([hidden])", { timeout: 5000 });
  await page.evaluate(() => loss.restoreContext());
  await page.waitForSelector("#note", { state: "hidden", timeout: 5000 });
  await settle(page);
  check((await colours(page, await pixels(page, "#canvas"))) > 200, "the scene is drawn again");
  said.splice(0, said.length, ...said.filter((line) => !/context/i.test(line)));
}

async function moves(page) {
  const still = await pixels(page, "#canvas");
  await page.locator("#canvas").focus();
  await page.keyboard.press(" ");
  await page.waitForFunction(() => raymap.statistics().travelled > 0.15 && raymap.statistics().travelled < 1, null, { timeout: 30000 });
  await page.keyboard.press(" ");
  await settle(page);
  const first = await pixels(page, "#canvas"), { travelled } = await statistics(page);
  check(travelled > 0 && travelled < 1, `the animation stands at ${travelled}`);
  check((await differing(page, still, first)) > 500, "the animation changes the picture");
  await picture(page, "moving.png");
  await page.keyboard.press(".");
  await settle(page);
  check((await changed(page, first)) > 20, "a step on changes the picture");
  await page.locator("#scrub").fill("300");
  check(Math.abs((await statistics(page)).travelled - 0.3) < 1e-9, "the slider sets the path travelled");
  await page.keyboard.press("a");
  check((await statistics(page)).travelled === 1, "whole rays again");
}

async function hearsKeys(page) {
  await page.locator("#canvas").focus();
  const before = await pixels(page, "#canvas");
  await page.keyboard.press("ArrowRight");
  await page.keyboard.press("+");
  await settle(page);
  check((await changed(page, before)) > 500, "arrows turn the scene");
  for (const key of ["1", "2", "3", "p", "c", "c", "p"]) await page.keyboard.press(key);
  await page.keyboard.press("0");
  await page.keyboard.press("f");
  await settle(page);
  check((await changed(page, before)) < 1280 * 800 / 80, "0 and f bring the first view back");
  await page.keyboard.press("?");
  check(await page.locator("#help").isVisible(), "? opens the help");
  await page.locator("#help button").click();
  for (const mode of ["path", "order", "natural"]) await page.selectOption("#colour", mode);
}

/* In a smaller window all of the scene is in sight again, unless somebody has chosen where to look. */
async function keepsTheSceneInSight(page) {
  await page.keyboard.press("0");
  await page.setViewportSize({ width: 900, height: 800 });
  await settle(page);
  check(await page.evaluate(() => raymap.isInSight()), "the scene is in sight in a narrower window");
  await page.keyboard.press("+");
  const height = await page.evaluate(() => raymap.zoom());
  await page.setViewportSize({ width: 1024, height: 700 });
  await settle(page);
  check(Math.abs((await page.evaluate(() => raymap.zoom())) / height - 1) < 1e-9, "what was zoomed stays so");
  await page.keyboard.press("0");
}

async function isWellLabelled(page) {
  const bare = await page.evaluate(() =>
    [...document.querySelectorAll("button, input, select, canvas")].filter((one) =>
      !(one.getAttribute("aria-label") || one.textContent.trim() || one.closest("label") || one.title)).length);
  check(bare === 0, `${bare} controls have no name`);
}

/* A rod with an opaque wall, which holds most of the light, is open; of many sources' names none stand upon each other. */
async function looksInside(page) {
  const orange = await (await pixels(page, "#canvas")).evaluate((all) => all.filter((v) => {
    const [r, g, b] = [v & 255, v >> 8 & 255, v >> 16 & 255];
    return r > 200 && g > 90 && g < 190 && b < 110;
  }).length);
  check(orange > 8000, `${orange} pixels have the colour of the rays in a rod`);
  const boxes = await page.evaluate(() => Array.from(document.querySelectorAll("#labels span"), (span) => span.getBoundingClientRect())
    .filter((box) => box.width > 0).map((box) => [box.left, box.top, box.right, box.bottom]));
  const meet = (a, b) => a[0] < b[2] && b[0] < a[2] && a[1] < b[3] && b[1] < a[3];
  check(boxes.length >= 2, `${boxes.length} names are shown`);
  check(!boxes.some((a, i) => boxes.some((b, k) => k > i && meet(a, b))), "no name stands upon another");
  await picture(page, "rod.png");
}

/* What shares a geometry is drawn at once, of no more triangles than are seen; each of it is still picked, hidden and found by itself. */
async function drawsManyAtOnce(page) {
  await page.locator("#canvas").focus();
  await page.keyboard.press("3");
  await settle(page);
  const far = await statistics(page);
  check(far.calls < 10, `${far.calls} calls draw 625 balls`);
  const box = await page.locator("#canvas").boundingBox(), name = "b312";
  const at = [Math.round(box.width / 2), Math.round(box.height / 2)];
  check((await page.evaluate(([x, y]) => raymap.bodyAt(x, y), at)) === name, "the one in the middle is picked");
  await page.evaluate(() => document.activeElement.blur());
  const before = await pixels(page, "#canvas");
  await page.mouse.click(box.x + at[0], box.y + at[1]);
  await page.locator("#tip button").click();
  await page.evaluate(() => document.activeElement.blur());
  await settle(page);
  const hidden = await changed(page, before);
  check(hidden > 30 && hidden < 2000, `${hidden} pixels are those of one that is hidden`);
  check((await page.evaluate(([x, y]) => raymap.bodyAt(x, y), at)) === null, "and is not picked");
  await page.evaluate(() => document.querySelector('[data-object="312"]').click());
  await settle(page);
  check((await changed(page, before)) === 0, "and is there again");
  for (let k = 0; k < 16; k++) await page.keyboard.press("+");
  await settle(page);
  const near = await statistics(page), each = near.triangles;
  await page.keyboard.press("3");
  check(far.triangles < 0.5 * 625 * each && each > 0, `${far.triangles} triangles of 625 balls, ${each} of those near by`);
  await page.locator("#objects-box summary").click();
  const rows = () => page.locator("#objects input[data-object]").evaluateAll((all) => all.filter((one) => one.checkVisibility({ contentVisibilityAuto: true })).length);
  check((await page.locator("#objects input[data-object]").count()) === 625 && (await rows()) < 600, `${await rows()} of 625 rows are laid out`);
  await page.fill("#find-object", "b312");
  await settle(page);
  check((await rows()) === 1, `a search finds ${await rows()}`);
  await page.fill("#find-object", "");
}

async function main() {
  const browser = await launch(...GRAPHICS);
  try {
    const page = await open(browser, "a.html");
    for (const part of [drawsTheScene, showsClasses, reportsUnderThePointer, asksForRegions, movesRegions, filtersOneAnother, searchesAndNames, moves, hearsKeys, keepsTheSceneInSight, isWellLabelled, losesItsContext])
      await part(page).catch((error) => check(false, `${part.name}: ${error.message}`));

    await turnTo(page, "two.html");
    await switchesCriteria(page).catch((error) => check(false, `switchesCriteria: ${error.message}`));

    await turnTo(page, "many.html");
    check((await page.inputValue("#colour")) === "order", "--color order");
    check(/ghost order 0/.test(await page.textContent("#legend")), "and its legend");
    await thinsWhileTurning(page).catch((error) => check(false, `thinsWhileTurning: ${error.message}`));

    await turnTo(page, "late.html");
    check((await page.evaluate(() => new Set(raymap.shown()).size)) === 300, "ids beyond 2^53 are told apart");
    await page.locator("#ray-box summary").click();
    await page.fill("#ray-id", "18446744073709548001");
    await page.press("#ray-id", "Enter");
    check((await page.textContent("#ray-name")) === "18446744073709548001", "and found");

    await turnTo(page, "rod.html");
    await looksInside(page).catch((error) => check(false, `looksInside: ${error.message}`));

    await turnTo(page, "crowd.html");
    await drawsManyAtOnce(page).catch((error) => check(false, `drawsManyAtOnce: ${error.message}`));

    await turnTo(page, "none.html");
    check(/No ray matches/.test(await page.textContent("#note")), "an empty selection is told");
    check((await colours(page, await pixels(page, "#canvas"))) > 50, "and its scene is drawn");
    await page.setViewportSize({ width: 390, height: 800 });
    await page.emulateMedia({ colorScheme: "dark" });
    await turnTo(page, "odd.html");
    check((await page.textContent("#detector")).includes("</script><b>\u00fc \\u003c-->"), "odd names come through");
    check((await page.title()) === "<b>\"odd'.raymap" && (await page.textContent("#title")) === "<b>\"odd'.raymap", "an odd title, too");
    check((await page.locator("b").count()) === 0, "and are no HTML");
    const wide = await page.evaluate(() => document.documentElement.scrollWidth);
    check(wide <= 390, `the page is ${wide} pixels wide on a screen of 390`);
    await picture(page, "phone.png");
  } finally {
    await browser.close();
  }
  const plain = await launch("--disable-3d-apis");
  try {
    const page = await open(plain, "a.html");
    check(/no WebGL/.test(await page.textContent("#note")), "a browser without WebGL is told so");
    check((await colours(page, await pixels(page, "#canvas"))) > 50, "and draws lines");
    said.splice(0, said.length, ...said.filter((line) => !/WebGL/.test(line))); // of the library, which tries
  } finally {
    await plain.close();
  }
  finish();
}

main().catch((error) => {
  console.log(`FAILED: ${error.stack}`);
  process.exitCode = 1;
});
