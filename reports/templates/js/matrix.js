// The body whose rotation matrix is never re-orthonormalised, beside one that stays rigid.

import { markOf } from "./contestants.js";
import { contestantOf, numbersFound } from "./data.js";
import { make } from "./dom.js";
import { filmOf } from "./film.js";
import { Clock, player } from "./player.js";

/** Put the body of a matrix that is never re-orthonormalised into host, beside one that stays rigid. */
export function matrixSection(host) {
  const [bent] = numbersFound("edge stretch")
    .flatMap((row) => {
      const film = filmOf(row.scene);
      return film ? [{ film, scene: row.scene, name: contestantOf(row), stretch: row.value }] : [];
    })
    .filter(({ name, film }) => film.body.shape === "box" && film.runs.get(name)?.vertices)
    .sort((a, b) => Math.abs(Math.log(a.stretch / 1.5)) - Math.abs(Math.log(b.stretch / 1.5)));
  if (!bent) return false;
  const { scene, name, film, stretch } = bent;
  const rigid = name.replace("matrix", "quaternion");
  host.append(
    make("p", { class: "headline" }, `It stops being a rotation: in ${scene} ${name} ends with an edge ${stretch.toFixed(2)} times its true length, at the same step at which ${film.runs.has(rigid) ? rigid : "the truth"} keeps the die rigid.`),
  );
  const pair = make("div", { class: "pair" });
  const clock = new Clock(film, "matrix", film.end); // begins at the end, where the difference is largest
  for (const [contestant, words] of [[name, "rotation matrix, never re-orthonormalised"], [rigid, "quaternion, normalised after each step"]]) {
    if (!film.runs.has(contestant)) continue;
    const box = make("figure");
    pair.append(box);
    player(box, film, { ghosts: () => [contestant], id: `flight-alone-${contestant.replaceAll(":", "-")}`, label: `${contestant} in ${scene}`, alone: true, controls: contestant === name, clock });
    box.append(make("figcaption", {}, markOf(contestant), ` ${contestant}: ${words}`));
  }
  host.append(pair);
  return true;
}
