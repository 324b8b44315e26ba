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
const [program, rays = "1000000", work = "duckdb-work"] = process.argv.slice(2);
if (!program) {
  console.error("usage: node duckdb_query.mjs RAYMAP [RAYS [FOLDER]]");
  process.exit(2);
}
const REPEATS = 7;
const REFLECT = 1; // event bit of a specular reflection
const TRANSMIT = 4;

// Each: a criterion, and queries that count the same rays; the fastest of them is compared.
// `history` has a row per ray with lists, in order, of its objects and events.
const scenes = {
  "double-gauss": [
    {
      criterion: "source(star) and hit('lens.*', reflect_specular) >= 2 and registered(sensor, rect(-6.1, -4.1, 6.1, 4.1))",
      sql: [
        `select count(*) from (select s.ray from segment s where s.object like 'lens.%' and s.event & ${REFLECT} <> 0
           and s.ray in (select r.ray from registration g join ray r using (ray) where r.source = 'star' and g.detector = 'sensor'
             and g.registered = 1 and g.x between -6.1 and 6.1 and g.y between -4.1 and 4.1)
           group by s.ray having count(*) >= 2)`,
        `with seen as (select distinct ray from registration where detector = 'sensor' and registered = 1 and x between -6.1 and 6.1
             and y between -4.1 and 4.1),
           often as (select ray from segment where object like 'lens.%' and event & ${REFLECT} <> 0 group by ray having count(*) >= 2)
         select count(*) from ray join seen using (ray) join often using (ray) where source = 'star'`,
        `select count(*) from history h where source = 'star'
           and len(list_filter(list_zip(objects, events), p -> p[1] like 'lens.%' and p[2] & ${REFLECT} <> 0)) >= 2
           and ray in (select ray from registration where detector = 'sensor' and registered = 1 and x between -6.1 and 6.1
             and y between -4.1 and 4.1)`,
      ],
    },
    {
      criterion: "not hit(cover.*)",
      sql: [
        `select (select count(*) from ray) - (select count(distinct ray) from segment where object like 'cover.%')`,
        `select count(*) from ray anti join (select ray from segment where object like 'cover.%') using (ray)`,
        `select count(*) from history where not list_has_any(objects, ['cover.1', 'cover.2', 'cover.edge.1'])`,
      ],
    },
  ],
  room: [
    {
      criterion: "source(lamp) and hit('*_wall', reflect_specular) >= 2 and registered(floor_map, rect(-1.01, -1.01, 1.01, 1.01))",
      sql: [
        `select count(*) from (select s.ray from segment s where s.object like '%\\_wall' escape '\\' and s.event & ${REFLECT} <> 0
           and s.ray in (select r.ray from registration g join ray r using (ray) where r.source = 'lamp' and g.detector = 'floor_map'
             and g.registered = 1 and g.x between -1.01 and 1.01 and g.y between -1.01 and 1.01)
           group by s.ray having count(*) >= 2)`,
        `with seen as (select distinct ray from registration where detector = 'floor_map' and registered = 1
             and x between -1.01 and 1.01 and y between -1.01 and 1.01),
           often as (select ray from segment where object in ('west_wall', 'east_wall', 'south_wall', 'north_wall')
             and event & ${REFLECT} <> 0 group by ray having count(*) >= 2)
         select count(*) from ray join seen using (ray) join often using (ray) where source = 'lamp'`,
      ],
    },
    {
      criterion: "not hit('*_wall')",
      sql: [
        `select (select count(*) from ray)
           - (select count(distinct ray) from segment where object in ('west_wall', 'east_wall', 'south_wall', 'north_wall'))`,
        `select count(*) from ray anti join
           (select ray from segment where object in ('west_wall', 'east_wall', 'south_wall', 'north_wall')) using (ray)`,
        `select count(*) from history where not list_has_any(objects, ['west_wall', 'east_wall', 'south_wall', 'north_wall'])`,
      ],
    },
    {
      criterion: "hit('board*', transmit_specular) >= 1 and ended(absorbed)",
      sql: [
        `select count(distinct ray) from segment join ray using (ray) where stop = 0 and object like 'board%' and event & ${TRANSMIT} <> 0`,
        `select count(*) from ray semi join (select ray from segment where object like 'board%' and event & ${TRANSMIT} <> 0)
           using (ray) where stop = 0`,
      ],
    },
  ],
};

const run = (...args) => execFileSync(program, args, { encoding: "utf8", maxBuffer: 1 << 28 });
const median = (numbers) => numbers.sort((a, b) => a - b)[numbers.length >> 1];

function bytesOf(folder) {
  return readdirSync(folder, { withFileTypes: true, recursive: true })
    .filter((entry) => entry.isFile())
    .reduce((sum, entry) => sum + statSync(path.join(entry.parentPath ?? entry.path, entry.name)).size, 0);
}

async function prepare(scene, db) {
  const map = path.join(work, `${scene}.raymap`), tables = path.join(work, `${scene}-tables`);
  if (!existsSync(map)) {
    run("trace", path.join(here, "../../examples", scene, "scene.yaml"), "-o", map, "-n", rays, "--encoding", "plain", "--quiet");
    run("index", map, "--quiet");
  }
  if (!existsSync(tables)) {
    execFileSync("/usr/bin/python3", ["-B", path.join(here, "export_csv.py"), map, tables + ".csv"]);
    mkdirSync(tables);
    for (const table of ["ray", "segment", "registration"])
      await db.run(`copy (from read_csv('${tables}.csv/${table}.csv', nullstr='\\N')) to '${tables}/${table}.parquet' (format parquet, compression zstd)`);
    await db.run(`copy (select ray, any_value(r.source) as source, any_value(stop) as stop, list(object order by leg) as objects,
      list(event order by leg) as events from '${tables}/segment.parquet' s join '${tables}/ray.parquet' r using (ray) group by ray order by ray)
      to '${tables}/history.parquet' (format parquet, compression zstd)`);
  }
  for (const table of ["ray", "segment", "registration", "history"])
    await db.run(`create or replace view ${table} as from '${tables}/${table}.parquet'`);
  console.log(`${scene}: map ${(bytesOf(map) / 1e6).toFixed(1)} MB, Parquet ${(bytesOf(tables) / 1e6).toFixed(1)} MB`);
  return map;
}

mkdirSync(work, { recursive: true });
const db = await (await DuckDBInstance.create(":memory:", { threads: "2" })).connect();
await db.run("set enable_progress_bar = false");
let apart = 0;
for (const [scene, questions] of Object.entries(scenes)) {
  const map = await prepare(scene, db);
  for (const { criterion, sql } of questions) {
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
    console.log(`  ${criterion}\n    ${matched} rays; raymap ${(1e3 * a).toFixed(2)} ms, DuckDB ` +
      `${theirs.map((t) => (1e3 * median(t)).toFixed(1)).join(", ")} ms: ${(best / a).toFixed(1)} times`);
  }
}
process.exit(apart ? 1 : 0);
