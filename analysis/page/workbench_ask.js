// SPDX-License-Identifier: MIT
//
// Questions to the server that shows this page; the first data.

/* Ids are of this page alone: other browsers hear of progress, too. open: id -> {command, begun, progress} */
const asking = { name: Math.random().toString(36).slice(2), n: 0, limit: 400, open: new Map(), told: () => {} };

/* Without the place in front, and the caret behind. */
const sentence = (message) => message.split("\n")[0].replace(/^[^ ]*:\d+:\d+: (error: )?/, "");

/* The result; an Error with `told`, what the server said of it, where it refuses. */
async function ask(command, words = {}) {
  const id = `${asking.name}.${++asking.n}`;
  let answer;
  asking.open.set(id, { command, begun: performance.now(), progress: null });
  asking.told();
  try {
    answer = await fetch("/api", { method: "POST", headers: { "Content-Type": "application/json" },
      body: JSON.stringify({ id, command, ...words }) });
    if (answer.ok) answer = await answer.json();
    else answer = { error: { message: answer.status === 503 ? "the server has ended" : `the server answers ${answer.status}` } };
  } catch (gone) {
    throw Object.assign(new Error("the server does not answer"), { told: {} });
  } finally {
    asking.open.delete(id);
    asking.told();
  }
  const { ok, result, error } = answer;
  if (ok) return result;
  throw Object.assign(new Error(sentence(error.message)), { told: error });
}

/* Of questions whose answers stand in one place, each is told whether it is the last: answers come in any order. */
function inTurn() {
  let last = 0;
  return () => {
    const own = ++last;
    return () => own === last;
  };
}

/* The scene first, at once: of a map of many rays the images take longer. */
const NO_RAYS = "ray < 0";
const asked = Promise.all([ask("model", { where: NO_RAYS, limit: 1 }), ask("names"), ask("scene"), ask("status")]);
drawsBySoftware(); // the first context takes long: meanwhile
const [firstData, firstNames, firstScene, firstStatus] = await asked;
Object.assign(firstData, { criterion: null, where: { ...firstData.where, list: [] }, total: 0 });
