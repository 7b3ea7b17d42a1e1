// The body whose rotation matrix is never re-orthonormalised, beside one that stays rigid.

import { markOf } from "./contestants.js";
import { contestantOf, numbersFound } from "./data.js";
import { make } from "./dom.js";
import { filmOf } from "./film.js";
import { Clock, player } from "./player.js";

/** The body whose rotation nobody repairs, beside one that stays rigid, both in flight. */
export function matrixSection(host) {
  const [bent] = numbersFound("bent edge")
    .flatMap((row) => {
      const film = filmOf(row.scene);
      return film ? [{ film, scene: row.scene, name: contestantOf(row), off: row.value }] : [];
    })
    .filter(({ name, film }) => film.body.shape === "box" && film.runs.get(name)?.vertices)
    .sort((a, b) => Math.abs(Math.log(a.off / 1.5)) - Math.abs(Math.log(b.off / 1.5)));
  if (!bent) return false;
  const { scene, name, film, off } = bent;
  const rigid = name.replace("matrix", "quaternion");
  host.append(
    make("p", { class: "headline" }, `It stops being one: in ${scene} ${name} ends with an edge ${off.toFixed(2)} times as long as it was, with the same step with which ${film.runs.has(rigid) ? rigid : "the truth"} keeps the die whole.`),
  );
  const pair = make("div", { class: "pair" });
  const clock = new Clock(film, "matrix", film.end); // at the end, where the difference is
  for (const [who, words] of [[name, "the matrix, nobody mends it"], [rigid, "the quaternion, set to length 1 each step"]]) {
    if (!film.runs.has(who)) continue;
    const box = make("figure");
    pair.append(box);
    player(box, film, { ghosts: () => [who], id: `flight-alone-${who.replaceAll(":", "-")}`, label: `${who} in ${scene}`, alone: true, controls: who === name, clock });
    box.append(make("figcaption", {}, markOf(who), ` ${who}: ${words}`));
  }
  host.append(pair);
  return true;
}
