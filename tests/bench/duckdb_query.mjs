// SPDX-License-Identifier: MIT
// Questions to a ray map against the best SQL that we found, put to DuckDB on the same rays as
// Parquet with zstd; two threads each, files in the page cache. README.md says how to run it.
import { execFileSync } from "node:child_process";
import { existsSync, mkdirSync, readdirSync, statSync } from "node:fs";
import { createRequire } from "node:module";
import path from "node:path";
import { fileURLToPath } from "node:url";

// Installed where the script is run, not where it stands.
const { DuckDBInstance } = createRequire(path.resolve("package.json"))("@duckdb/node-api");

const here = path.dirname(fileURLToPath(import.meta.url));
const [program, nRays = "1000000", work = "duckdb-work"] = process.argv.slice(2);
if (!program) {
  console.error("usage: node duckdb_query.mjs RAYMAP [RAYS [FOLDER]]");
  process.exit(2);
}
const REPEATS = 7;
const REFLECT = 1, REFLECT_DIFFUSE = 2; // event bits

// Rays of a step; of a step met so often; of none.
const steps = (where) => [
  `select count(distinct ray) from segment where ${where}`,
  `select count(*) from ray semi join (select ray from segment where ${where}) using (ray)`,
];
const often = (where, n) => [`select count(*) from (select ray from segment where ${where} group by ray having count(*) >= ${n})`];
const never = (where) => [
  `select (select count(*) from ray) - (select count(distinct ray) from segment where ${where})`,
  `select count(*) from ray anti join (select ray from segment where ${where}) using (ray)`,
];
// One step and, later, another.
const then = (first, second) => [
  `select count(*) from (select ray from segment group by ray having min(case when ${first} then leg end) < max(case when ${second} then leg end))`,
  `select count(distinct a.ray) from (select ray, leg from segment where ${first}) a join (select ray, leg from segment where ${second}) b
     on a.ray = b.ray and a.leg < b.leg`,
];
const registered = (where) => [
  `select count(distinct ray) from registration where registered = 1 and ${where}`,
  `select count(*) from ray semi join (select ray from registration where registered = 1 and ${where}) using (ray)`,
];
const rays = (where) => [`select count(*) from ray where ${where}`];
// Rays of a step, so often, with a number: either first.
const both = (where, n, number) => [
  `select count(*) from ray semi join (select ray from segment where ${where} group by ray having count(*) >= ${n}) using (ray) where ${number}`,
  `select count(*) from (select ray from segment where ${where} and ray in (select ray from ray where ${number}) group by ray having count(*) >= ${n})`,
];

// Each class: a criterion, and queries that count the same rays; the fastest of them is compared.
const lens = "object like 'lens.%'", walls = "object in ('west_wall', 'east_wall', 'south_wall', 'north_wall')";
const scenes = {
  "double-gauss": {
    source: ["source(sun)", rays("source = 'sun'")],
    object: ["hit(lens.3)", steps("object = 'lens.3'")],
    event: ["hit(lens.*, reflect_specular)", steps(`${lens} and event & ${REFLECT} <> 0`)],
    count: ["hit(lens.*, reflect_specular) >= 2", often(`${lens} and event & ${REFLECT} <> 0`, 2)],
    never: ["not hit(cover.*)", never("object like 'cover.%'")],
    path: ['path(".* R@lens.3 .* R@lens.2 .*")', then(`object = 'lens.3' and event & ${REFLECT} <> 0`, `object = 'lens.2' and event & ${REFLECT} <> 0`)],
    region: ["registered(sensor, rect(-6.1, -4.1, 6.1, 4.1))", registered("detector = 'sensor' and x between -6.1 and 6.1 and y between -4.1 and 4.1")],
    place: ["registered(sensor where x > 3.21)", registered("detector = 'sensor' and x > 3.21")],
    angle: ["registered(sensor where angle > 12.34)", registered("detector = 'sensor' and angle > 12.34")],
    time: ["registered(sensor where time > 0.601 ns)", registered("detector = 'sensor' and time > 0.601")],
    length: ["path_length > 150.25", rays("path_length > 150.25")],
    "event and length": ["hit(lens.*, reflect_specular) >= 2 and path_length > 150.25", both(`${lens} and event & ${REFLECT} <> 0`, 2, "path_length > 150.25")],
  },
  room: {
    source: ["source(lamp)", rays("source = 'lamp'")],
    object: ["hit(ball_1)", steps("object = 'ball_1'")],
    event: ["hit('*_wall', reflect_specular)", steps(`${walls} and event & ${REFLECT} <> 0`)],
    count: ["hit(floor, reflect_diffuse) >= 2", often(`object = 'floor' and event & ${REFLECT_DIFFUSE} <> 0`, 2)],
    never: ["not hit('*_wall')", never(walls)],
    path: ['path(".* D@floor .* D@ceiling .*")', then(`object = 'floor' and event & ${REFLECT_DIFFUSE} <> 0`, `object = 'ceiling' and event & ${REFLECT_DIFFUSE} <> 0`)],
    region: ["registered(floor_map, rect(-1.01, -1.01, 1.01, 1.01))", registered("detector = 'floor_map' and x between -1.01 and 1.01 and y between -1.01 and 1.01")],
    place: ["registered(floor_map where x > 1.21)", registered("detector = 'floor_map' and x > 1.21")],
    angle: ["registered(floor_map where angle > 40.12)", registered("detector = 'floor_map' and angle > 40.12")],
    time: ["registered(floor_map where time > 40.1 ns)", registered("detector = 'floor_map' and time > 40.1")],
    length: ["path_length > 15.13", rays("path_length > 15.13")],
    "event and length": ["hit(ball_1) and path_length > 15.13", both("object = 'ball_1'", 1, "path_length > 15.13")],
  },
};

const run = (...args) => execFileSync(program, args, { encoding: "utf8", maxBuffer: 1 << 28 });
const median = (numbers) => numbers.sort((a, b) => a - b)[numbers.length >> 1];

function bytesOf(folder) {
  return readdirSync(folder, { withFileTypes: true, recursive: true })
    .filter((entry) => entry.isFile())
    .reduce((sum, entry) => sum + statSync(path.join(entry.parentPath ?? entry.path, entry.name)).size, 0);
}

function trace(scene, name, ...options) {
  const map = path.join(work, name);
  if (!existsSync(map))
    run("trace", path.join(here, "../../examples", scene, "scene.yaml"), "-o", map, "-n", nRays, "--quiet", ...options);
  return map;
}

// A map as `trace` makes it, and the same rays as tables.
async function prepare(scene, db) {
  const map = trace(scene, `${scene}.raymap`), tables = path.join(work, `${scene}-tables`);
  if (!existsSync(tables)) {
    execFileSync("/usr/bin/python3", ["-B", path.join(here, "export_csv.py"), trace(scene, `${scene}-plain.raymap`, "--encoding", "plain"), tables + ".csv"]);
    mkdirSync(tables);
    for (const table of ["ray", "segment", "registration"])
      await db.run(`copy (from read_csv('${tables}.csv/${table}.csv', nullstr='\\N')) to '${tables}/${table}.parquet' (format parquet, compression zstd)`);
  }
  for (const table of ["ray", "segment", "registration"])
    await db.run(`create or replace view ${table} as from '${tables}/${table}.parquet'`);
  console.log(`${scene}, ${Number(nRays).toLocaleString("en")} rays: map ${(bytesOf(map) / 1e6).toFixed(1)} MB, Parquet ${(bytesOf(tables) / 1e6).toFixed(1)} MB`);
  return map;
}

mkdirSync(work, { recursive: true });
const db = await (await DuckDBInstance.create(":memory:", { threads: "2" })).connect();
await db.run("set enable_progress_bar = false");
let apart = 0;
for (const [scene, questions] of Object.entries(scenes)) {
  const map = await prepare(scene, db);
  for (const [kind, [criterion, sql]] of Object.entries(questions)) {
    const ours = [], theirs = sql.map(() => []);
    let matched;
    for (let i = -1; i < REPEATS; i++) { // -1: warms the cache
      const answer = JSON.parse(run("query", map, criterion, "--count", "--json", "--threads", "2"));
      matched = answer.rays.matched;
      if (i >= 0) ours.push(answer.seconds);
      for (const [k, text] of sql.entries()) {
        const begun = performance.now();
        const count = Number((await db.runAndReadAll(text)).getRows()[0][0]);
        if (i >= 0) theirs[k].push(1e-3 * (performance.now() - begun));
        if (count !== matched) {
          console.log(`DIFFERENT: raymap ${matched}, DuckDB ${count}: ${text}`);
          apart++;
        }
      }
    }
    const best = Math.min(...theirs.map(median)), a = median(ours);
    console.log(`  ${kind}: ${criterion}\n    ${matched} rays; raymap ${(1e3 * a).toFixed(2)} ms, DuckDB ` +
      `${theirs.map((t) => (1e3 * median(t)).toFixed(1)).join(", ")} ms: ${(best / a).toPrecision(3)} times`);
  }
}
process.exit(apart ? 1 : 0);
