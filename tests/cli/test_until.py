#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""The promise: `query --until P%` answers from the first rays of a map as a map of these rays alone would, is as exact as it says,
and has the same answer for any number of ranks and either encoding; what cannot be so exact is asked of all rays, and told."""
import json
import sys

sys.dont_write_bytecode = True
import served  # noqa: E402
from asking import SOURCE, check, finish, run, trace  # noqa: E402

KEYS = ("rays", "segments", "flux", "registered")
QUESTIONS = ("registered(sensor)", "registered(sensor where ghost_order == 0)", "path_length > 150 and source(star)", "hit(lens.3, reflect) and ray > 5")


def ask(name, *words, ranks=1):
    if ranks > 1:
        return json.loads(run("query", name, *words, "--json", ranks=ranks))
    return served.ask("query", name, *words)


trace("double-gauss", "lens.raymap", 300000)
trace("double-gauss", "plain.raymap", 300000, "--encoding", "plain")
parts = {n: trace("double-gauss", f"first-{n}.raymap", n) for n in (65536, 131072, 262144)}
seen = set()
for question in QUESTIONS:
    for percent in (0.3, 1, 3):
        told = ask("lens.raymap", question, "--until", f"{percent}%")
        until = told["until"]
        seen.add(until["rays"])
        check(until["of_rays"] == 300000 and until["relative"] == percent / 100, f"{until}")
        check(until["reached"] == (told["flux"]["standard_error"] <= percent / 100 * told["flux"]["matched"]), f"{question}: {until}")
        alone = ask(parts.get(until["rays"], "lens.raymap"), question)
        check([told[key] for key in KEYS] == [alone[key] for key in KEYS], f"{question}, {percent} %: of {until['rays']} rays alone")
        check(told["rays_traced"] == 300000 and told["complete"], "the map's own numbers")
        check(until["reached"] or until["rays"] == 300000, "no more to ask")
        for name, ranks in (("lens.raymap", 3), ("plain.raymap", 1))[percent != 0.3 or question != QUESTIONS[1]:]:
            again = ask(name, question, "--until", percent / 100, ranks=ranks)
            check([again[key] for key in (*KEYS, "until")] == [told[key] for key in (*KEYS, "until")], f"{question} again: {name}, {ranks} ranks")
check(len(seen) >= 3, f"{seen}")
both = json.loads(run("query", "lens.raymap", *QUESTIONS[:2], "hit(lens.3, reflect)", "--until", "2%", "--json"))
check(len({one["until"]["rays"] for one in both}) == 1 and all(one["until"]["reached"] for one in both), "several criteria: all of them")
never = run("query", "lens.raymap", "bounces > 500", "--until", "1%")
check("NOT reached, by the first 300,000 of 300,000 rays" in never, never)
check(ask("lens.raymap", "all", "--until", "1%")["until"]["rays"] == 65536, "a flux without an error")

for words in (("--of", "path_length"), ("--of", "angle(sensor)", "--by", "source"), ("--of", "x(sensor)", "--where", "source(star)")):
    told = json.loads(run("stats", "lens.raymap", *words, "--until", "8%" if "--by" in words else "2%", "--json", ranks=1 + ("--by" in words)))
    until = told.pop("until")
    alone = served.ask("stats", parts.get(until["rays"], "lens.raymap"), *words)
    for one in (told, alone):
        for key in ("map", "rays_traced", "rays_asked", "seconds"):
            one.pop(key, None)
    check(until["reached"] and until["rays"] < 300000 and told == alone, f"stats {words}: {until}")
for words, reached in ((("bounces > 500",), False), (("all", "bounces > 500"), False), (("all", "source(star)"), True)):
    for by in ((), ("--by", "source")):
        until = json.loads(run("stats", "lens.raymap", "--of", "path_length", *(w for one in words for w in ("--where", one)), *by, "--until", "8%", "--json"))["until"]
        check(until["reached"] == reached and (until["rays"] == 300000) == (not reached), f"stats of {words} {by}: {until}")
run("stats", "lens.raymap", "--of", "path_length", "--until", "2%", "-o", "until.csv", "--force")
with open("until.csv", encoding="utf-8") as file:
    check("# until: 2 % reached, by the first 65,536 of 300,000 rays" in file.read(), "in the file")

for words in ((), ("--where", "source(star)", "--cells", "30x20"), ("--where", "bounces > 500"), ("--spot", "--where", "source(star)")):
    told = json.loads(run("detector", "lens.raymap", "sensor", *words, "--until", "2%", "--json", ranks=1 + ("--cells" in words)))
    until = told.pop("until")
    alone = served.ask("detector", parts.get(until["rays"], "lens.raymap"), "sensor", *words)
    for one in (told, alone):
        for key in ("map", "rays_traced", "rays_asked", "seconds"):
            one.pop(key, None)
    check(told == alone and until["reached"] == ("bounces" not in str(words)), f"detector {words}: {until}")
run("detector", "lens.raymap", "sensor", "--until", "3%", "-o", "until.svg", "--force")
with open("until.svg", encoding="utf-8") as file:
    check("3 % reached, by the first" in file.read(), "in the picture")
check("--tally is of all rays" in run("detector", "lens.raymap", "sensor", "--until", "3%", "--tally", status=2), "--tally")

run("select", "lens.raymap", "late", "ray > 100000")
for question in ("ray > 100000", "not ray <= 100000 and flux > 0", "2 * ray - segments > 200000", "@late"):
    told = ask("lens.raymap", question, "--until", "20%")
    check(told["until"]["rays"] == 300000 and told["rays"]["matched"] > 199000, f"{question}: {told['until']}, {told['rays']}")
for words in (("stats", "lens.raymap", "--of", "flux", "--where", "@late"),
              ("stats", "lens.raymap", "--of", "2 * ray"), ("detector", "lens.raymap", "sensor", "--where", "ray > 9")):
    until = served.ask(*words, "--until", "20%")["until"]
    check(until["rays"] == 300000, f"{words}: {until}")

trace("scintillator", "events.raymap", 70000, "--set", "sources.muon.count=counted")
trace("room", "colours.raymap", 70000)
run("trace", SOURCE / "examples" / "room" / "scene.yaml", "-o", "colours.raymap", "-n", 1000, "--append", "--color", "rgb", "--quiet")
for name in ("events.raymap", "colours.raymap"):  # the first are no sample
    until = ask(name, "all", "--until", "50%")["until"]
    check(until["rays"] == until["of_rays"] >= 70000, f"{name}: {until}")

run("query", "lens.raymap", "registered(sensor)", "-o", "picked.raymap", "--force", "--quiet")
for words, told in ((("lens.raymap", "all", "--until", "2"), "1% or 0.01"), (("lens.raymap", "all", "--until", "-1%"), "1% or 0.01"),
                    (("lens.raymap", "all", "--until", "x"), "1% or 0.01"), (("lens.raymap", "all", "--until", "1%", "--limit", 3), "--limit"),
                    (("picked.raymap", "all", "--until", "1%"), "no sample")):
    error = run("query", *words, status=2)
    check(told in error, f"{words}: {error}")
finish()
