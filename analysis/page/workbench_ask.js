// SPDX-License-Identifier: MIT
//
// Questions to the server that shows this page; the first data.

const asking = { id: 0, limit: 400 };

/* Without the place in front, and the caret behind. */
const sentence = (message) => message.split("\n")[0].replace(/^[^ ]*:\d+:\d+: (error: )?/, "");

/* The result; an Error with `told`, what the server said of it, where it refuses. */
async function ask(command, words = {}) {
  let answer;
  try {
    answer = await fetch("/api", { method: "POST", headers: { "Content-Type": "application/json" },
      body: JSON.stringify({ id: ++asking.id, command, ...words }) });
  } catch (gone) {
    throw Object.assign(new Error("the server does not answer"), { told: {}, gone: true });
  }
  if (!answer.ok) throw Object.assign(new Error(`the server answers ${answer.status}`), { told: {}, gone: true });
  const { ok, result, error } = await answer.json();
  if (ok) return result;
  throw Object.assign(new Error(sentence(error.message)), { told: error });
}

const firstData = await ask("model", { limit: asking.limit });
