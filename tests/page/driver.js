// SPDX-License-Identifier: MIT
//
// A real chromium for the tests of pages: opens them, compares pixels, gathers what went wrong.
// PICTURES=1 keeps screenshots.
"use strict";
const { execFileSync } = require("child_process");
const path = require("path");
const { chromium } = require("playwright-core");

const folder = path.resolve(process.argv[2]);
const CHROMIUM = process.env.CHROMIUM || "/usr/bin/chromium";
// WebGL alone is drawn as by a graphics card: all of the page would take the processor two times as long.
const GRAPHICS = ["--disable-gpu-compositing", "--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader", "--disable-dev-shm-usage"];

let failures = 0;
function check(holds, what) {
  if (holds) return;
  console.log(`FAILED: ${what}`);
  failures++;
}

function raymap(...words) {
  return execFileSync(process.env.RAYMAP, words, { encoding: "utf8", cwd: folder });
}
const counted = (map, criterion) =>
  JSON.parse(raymap("query", map, criterion, "--count", "--json", "--quiet")).rays.matched;

const said = []; // errors of any page

/* In a page of its own, which is a process that takes seconds to begin; turnTo goes on to another file in it. */
async function open(browser, address, options) {
  const context = await browser.newContext({ viewport: { width: 1024, height: 700 }, colorScheme: "light", ...options });
  const page = await context.newPage();
  const file = () => path.basename(page.url());
  page.on("console", (message) => ["error", "warning"].includes(message.type()) && !/^\[\.WebGL.*Performance.*ReadPixels/.test(message.text()) && said.push(`${file()}: ${message.text()}`));
  page.on("pageerror", (error) => said.push(`${file()}: ${error.message}`));
  const own = new URL(address).origin;
  page.on("request", (request) => /^(file|data|blob):/.test(request.url()) || request.url().startsWith(own) || said.push(`${file()} asks for ${request.url()}`));
  await turnTo(page, address);
  return page;
}

async function turnTo(page, address) {
  await page.goto(address, { timeout: 90000 });
  await page.waitForSelector("html[data-ready]", { timeout: 90000 });
  await settle(page);
}

/* Until nothing moves any more, and a frame asked for then has been drawn. */
async function settle(page) {
  await page.evaluate(async () => {
    const frame = () => new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done)));
    await frame();
    while (!raymap.statistics().resting) await new Promise((done) => setTimeout(done, 50));
    raymap.draw();
    await frame();
  });
}

const statistics = (page) => page.evaluate(() => raymap.statistics());

/* What a part of the page looks like: its pixels, kept in the page. */
async function pixels(page, selector) {
  const png = (await page.locator(selector).screenshot()).toString("base64");
  return page.evaluateHandle(async (text) => {
    const image = new Image();
    image.src = "data:image/png;base64," + text;
    await image.decode();
    const canvas = document.createElement("canvas");
    [canvas.width, canvas.height] = [image.width, image.height];
    const context = canvas.getContext("2d");
    context.drawImage(image, 0, 0);
    return new Uint32Array(context.getImageData(0, 0, image.width, image.height).data.buffer);
  }, png);
}

/* How many pixels differ; how many colours there are. */
const differing = (page, a, b) => page.evaluate(([p, q]) => p.reduce((n, v, i) => n + (v !== q[i] ? 1 : 0), 0), [a, b]);
const colours = (page, a) => page.evaluate((p) => new Set(p).size, a);

async function picture(page, name) {
  if (process.env.PICTURES) await page.screenshot({ path: path.join(folder, name) });
}

async function drag(page, selector, from, to) {
  const box = await page.locator(selector).boundingBox();
  const at = ([u, v]) => [box.x + u * box.width, box.y + v * box.height];
  await page.mouse.move(...at(from));
  await page.mouse.down();
  await page.mouse.move(...at([(from[0] + to[0]) / 2, (from[1] + to[1]) / 2]));
  await page.mouse.move(...at(to));
  await page.mouse.up();
}

const launch = (...words) => chromium.launch({ executablePath: CHROMIUM, args: ["--no-sandbox", ...words] });

/* The end: what consoles said is wrong, too. */
function finish() {
  for (const line of said) check(false, line);
  console.log(failures ? `${failures} failures` : "all as expected");
  process.exitCode = failures ? 1 : 0;
}

module.exports = { GRAPHICS, check, colours, counted, differing, drag, finish, folder, launch, open, picture, pixels, raymap, said, settle, statistics, turnTo };
