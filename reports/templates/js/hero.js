// The die beside the board: the truth and the default that is furthest from it.

import { defaultFindings, markOf, rolesOf } from "./contestants.js";
import { contestantOf, findingValue, rows } from "./data.js";
import { make } from "./dom.js";
import { filmOf } from "./film.js";
import { finite, si } from "./numbers.js";
import { player } from "./player.js";
import { openScene } from "./scenes.js";
import { follow, state } from "./state.js";

/** Put the truth and the least accurate default of a scene into host: of the chosen scene, or of a telling one. */
export function hero(host) {
  const films = rows("scenes.csv").flatMap((row) => filmOf(row.scene) ?? []);
  if (!films.length) return;
  let stage = null;
  follow(["scene"], () => {
    const film = films.find((one) => one.scene === state.scene) ?? openingFilm(films);
    const { scene } = film;
    stage?.stop();
    host.replaceChildren();
    const worst = worstDefault(film);
    const ghosts = worst ? [worst.name] : [];
    const title = rows("scenes.csv").find((row) => row.scene === scene)?.title || scene;
    host.append(make("p", { class: "hero-title" }, make("a", { href: `#scene-${scene}`, click: (event) => openScene(event, scene) }, title)));
    stage = player(host, film, { ghosts: () => ghosts, id: "flight-first", label: `The die of ${scene} in flight: the truth solid${worst ? `, ${worst.name} as a frame` : ""}`, autoplay: true });
    const roles = worst && rolesOf(worst.name);
    host.append(make("p", { class: "note" }, "Solid: the truth. ", worst ? [markOf(worst.name), ` ${worst.name}${roles ? `, ${roles}` : ""}: error up to ${si(worst.error, "m", 2)}.`] : "Every default follows it."));
  });
}

/**
 * The least accurate default of a scene, or requested contestant of an engine without one; null where all are accurate.
 * @param {Film} film
 */
function worstDefault(film) {
  const ranked = defaultFindings(film.scene)
    .map((row) => ({ name: contestantOf(row), error: findingValue(row) }))
    .map((one) => ({ ...one, error: finite(one.error) ? one.error : 0 }))
    .filter(({ name, error }) => film.runs.has(name) && error > 1e-6 * film.size)
    .sort((a, b) => b.error - a.error);
  return ranked[0] ?? null;
}

/**
 * The film to begin with: one where the least accurate default is visibly wrong, and still in the picture.
 * @param {Film[]} films
 */
function openingFilm(films) {
  const ranked = films
    .map((film) => ({ film, share: (worstDefault(film)?.error ?? 0) / film.size }))
    .map((one) => ({ ...one, rank: one.share > 0 ? Math.abs(Math.log10(one.share / 0.6)) + (one.film.end < 1 ? 1 : 0) : 99 }));
  return ranked.sort((a, b) => a.rank - b.rank)[0].film;
}
