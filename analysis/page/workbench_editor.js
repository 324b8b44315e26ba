// SPDX-License-Identifier: MIT
//
// Editors of criteria and of the scene's text (CodeMirror): colours, completion, mistakes where
// they are.

const LETTERS = [["T", "refracted", "transmit_specular"], ["R", "reflected", "reflect_specular"], ["I", "totally reflected", "total_reflection"],
  ["D", "scattered back", "reflect_diffuse"], ["d", "scattered through", "transmit_diffuse"], ["S", "scattered in a medium", "scatter_volume"],
  ["A", "absorbed", "absorb"], ["V", "registered", null], ["X", "left", "left"], [".", "anything", null]];
const TESTS = ["all", "and", "or", "not", "hit", "source", "registered", "crossed", "path", "event", "medium", "ended", "where",
  "rect", "ellipse", "cell", "angle", "x", "y", "z", "segments", "bounces", "ghost_order", "scatter_order", "wavelength", "flux",
  "path_length", "optical_path", "ray", "start_x", "start_y", "start_z"];
const EVENTS = ["reflect", "transmit", "specular", "diffuse", "scatter", "absorb", "reflect_specular", "reflect_diffuse", "transmit_specular",
  "transmit_diffuse", "total_reflection", "scatter_volume", "fluoresce", "element", "gradient", "left", "limit", "error"];

CodeMirror.defineSimpleMode("criterion", { start: [
  { regex: /#.*/, token: "comment" },
  { regex: /"[^"]*"?/, token: "string" },
  { regex: /'(?:[^']|'')*'?/, token: "string-2" },
  { regex: /(?:and|or|not|where|all)\b/, token: "keyword" },
  { regex: /@[\w.]+/, token: "def" },
  { regex: /[A-Za-z_][\w.:]*(?=\s*\()/, token: "builtin" },
  { regex: new RegExp(`(?:${EVENTS.join("|")})\\b`), token: "atom" },
  { regex: /\d+(?:\.\d*)?(?:e[-+]?\d+)?/i, token: "number" },
  { regex: /[<>=!]+/, token: "operator" },
  { regex: /[A-Za-z_\u00c0-\uffff][\w.*?\u00c0-\uffff]*/, token: "variable" },
] });

/* As the criterion language writes it. */
const quoted = (name) => (/^[A-Za-z_][\w.]*$/.test(name) ? name : `'${name.replaceAll("'", "''")}'`);

const names = () => ({ object: [...scene.objects, ...scene.groups].map((one) => quoted(one.name)),
  source: scene.sources.map((one) => quoted(one.name)), detector: detectors.map((one) => one.word || quoted(one.name)),
  medium: scene.media.map(quoted) });

/* What may stand behind `before`: words of the language, or names of what the function is about. */
function wordsAfter(before) {
  const open = /([A-Za-z_]+)\(([^()]*)$/.exec(before), own = names();
  if (!open) return [...TESTS, ...own.object];
  const [, call, inside] = open, first = !inside.includes(",");
  if (call === "hit" && !first) return EVENTS;
  if (["event"].includes(call)) return EVENTS;
  if (call === "source") return own.source;
  if (call === "medium") return own.medium;
  if (["registered", "crossed", "x", "y", "angle", "time", "optical_path", "cell"].includes(call)) return first ? [...own.detector, ...TESTS] : ["rect", "ellipse"];
  if (call === "path") return LETTERS.flatMap(([letter]) => (letter === "V" ? own.detector : own.object).map((name) => `${letter}@${name}`));
  return [...own.object, ...TESTS];
}

function completion(editor) {
  const at = editor.getCursor(), line = editor.getLine(at.line).slice(0, at.ch);
  const typed = /['\w.@:\u00c0-\uffff]*$/.exec(line)[0], begin = at.ch - typed.length;
  const fits = (word) => word.toLowerCase().includes(typed.toLowerCase()) && word !== typed;
  const starts = (word) => (word.toLowerCase().startsWith(typed.toLowerCase()) ? 0 : 1);
  const list = [...new Set(wordsAfter(line.slice(0, begin)))].filter(fits).sort((a, b) => starts(a) - starts(b)).slice(0, 60);
  return { list, from: CodeMirror.Pos(at.line, begin), to: at };
}

function makeEditor(place, label, options) {
  const editor = CodeMirror(place, { lineWrapping: true, matchBrackets: true, tabSize: 2, ...options });
  editor.getInputField().setAttribute("aria-label", label);
  /* Tab goes on to the next control; Esc leaves the editor. */
  editor.setOption("extraKeys", { Tab: false, "Shift-Tab": false, Esc: () => editor.getInputField().blur(), ...options.extraKeys });
  return editor;
}

/* Marks mistakes [{line, column, text}], lines and columns from 1, in place of those before. */
function markMistakes(editor, mistakes) {
  for (const mark of editor.getAllMarks()) mark.clear();
  for (const { line, column, text } of mistakes) {
    if (!line || line > editor.lineCount()) continue;
    const content = editor.getLine(line - 1), length = content.length;
    const from = Math.min((column || 1) - 1, Math.max(length - 1, 0));
    const word = /^[\w.'\u00c0-\uffff]+|^\S?/.exec(content.slice(from))[0].length || 1;
    editor.markText({ line: line - 1, ch: from }, { line: line - 1, ch: Math.min(from + word, Math.max(length, 1)) },
      { className: "mistake", attributes: { title: text } });
  }
}

/* Calls when nothing has come for a while. */
function later(milliseconds, call) {
  let timer = 0;
  return (...words) => {
    clearTimeout(timer);
    timer = setTimeout(() => call(...words), milliseconds);
  };
}
