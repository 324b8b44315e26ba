// SPDX-License-Identifier: MIT
//
// Light on its way: every ray is drawn up to the path travelled, the same for all of them; where
// the map has times, up to the same time.

const DURATION = 6; // seconds from the first emission to the last end, at speed 1
const TRAIL = 0.05; // of the longest path

const player = { playing: false, at: 1, last: 0 };
whenData(() => {
  byId("scrub").setAttribute("aria-label", times ? "time" : "path travelled");
  rayUniforms.trail.value = Math.max(TRAIL * longestPath, 1e-12);
});

/* 0 to 1; 1: whole rays. */
function setTravelled(at) {
  player.at = Math.min(Math.max(at, 0), 1);
  const still = player.at >= 1;
  rayUniforms.now.value = still ? 3e38 : player.at * longestPath;
  rayUniforms.fade.value = still ? 1 : 0.45;
  byId("scrub").value = String(Math.round(1000 * player.at));
  byId("travelled").textContent = still ? "whole paths" : `${figure(firstTime + player.at * longestPath, 4)} ${times ? "ns" : scene.unit}`;
  redraw();
}

function advance(time) {
  if (!player.playing) return false;
  const seconds = player.last ? Math.min((time - player.last) / 1000, 0.25) : 0;
  player.last = time;
  setTravelled(player.at + (seconds / DURATION) * Math.pow(2, Number(byId("speed").value)));
  if (player.at >= 1) setPlaying(false);
  return player.playing;
}
frames.animate = advance;

function setPlaying(playing) {
  player.playing = playing && strokes.count > 0;
  player.last = 0;
  if (player.playing && player.at >= 1) setTravelled(0);
  byId("play").dataset.playing = player.playing;
  byId("play").setAttribute("aria-label", player.playing ? "pause" : "play");
  redraw();
}

byId("play").addEventListener("click", () => setPlaying(!player.playing));
byId("scrub").addEventListener("input", (event) => {
  setPlaying(false);
  setTravelled(Number(event.target.value) / 1000);
});
byId("still").addEventListener("click", () => {
  setPlaying(false);
  setTravelled(1);
});
