// The die beside the board: the reference and the default that is furthest from it.

import { defaultFindings, markOf, rolesOf } from "./contestants.js";
import { DATA, contestantOf, findingValue, rows } from "./data.js";
import { make } from "./dom.js";
import { filmOf } from "./film.js";
import { si } from "./numbers.js";
import { player } from "./player.js";
import { openScene } from "./scenes.js";
import { follow, state } from "./state.js";

/** The die beside the board: the truth and the engine that is furthest off at its default, or as asked. */
export function hero(host) {
  const candidates = rows("scenes.csv").map((scene) => scene.scene).filter((scene) => DATA.films[scene]);
  if (!candidates.length) return;
  let stage = null;
  follow(["scene"], () => {
    const scene = candidates.includes(state.scene) ? state.scene : openingScene(candidates);
    stage?.stop();
    host.replaceChildren();
    const worst = worstDefault(scene);
    const ghosts = worst ? [worst.name] : [];
    host.append(make("p", { class: "hero-title" }, make("a", { href: `#scene-${scene}`, click: (event) => openScene(event, scene) }, rows("scenes.csv").find((row) => row.scene === scene).title || scene)));
    stage = player(host, scene, { ghosts: () => ghosts, id: "flight-first", label: `The die of ${scene} in flight: the truth solid${worst ? `, ${worst.name} as a frame` : ""}`, autoplay: true });
    host.append(make("p", { class: "note" }, "Solid: the truth. ", worst ? [markOf(worst.name), ` ${worst.name}${rolesOf(worst.name) ? `, ${rolesOf(worst.name)}` : ""}: up to ${si(worst.error, "m", 2)} off.`] : "Nobody is off."));
  });
}

/** The default that is furthest off in a scene, or what was asked of an engine without one; null where none is off. */
function worstDefault(scene) {
  const film = filmOf(scene);
  const off = defaultFindings(scene)
    .map((row) => ({ name: contestantOf(row), error: findingValue(row) }))
    .filter(({ name }) => film.others.has(name))
    .filter(({ error }) => error !== null && Number.isFinite(error) && error > 1e-6 * film.size)
    .sort((a, b) => b.error - a.error);
  return off[0] ?? null;
}

/** The scene to begin with: where a first one goes astray enough to be seen, and not out of the picture. */
function openingScene(candidates) {
  const ranked = candidates
    .map((scene) => ({ scene, off: (worstDefault(scene)?.error ?? 0) / filmOf(scene).size, length: filmOf(scene).t.at(-1) }))
    .map((one) => ({ ...one, rank: one.off > 0 ? Math.abs(Math.log10(one.off / 0.6)) + (one.length < 1 ? 1 : 0) : 99 }));
  return ranked.sort((a, b) => a.rank - b.rank)[0].scene;
}
