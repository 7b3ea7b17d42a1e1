// The player: one clock per scene, shared by its stage, its slider and the cursors of its charts.

import { filled, make, reducedMotion, whenThemeChanges } from "./dom.js";
import { filmOf } from "./film.js";
import { figure } from "./numbers.js";
import { figureTools } from "./save.js";
import { drawMoment, drawWith } from "./stage.js";
import { choose, follow, state } from "./state.js";
import { SvgPen } from "./svg-pen.js";

const PLAYS_S = 6; // a film of any length, unless it is about that long

const clocks = new Map();

/**
 * The clock of a film, shared by all figures of its scene.
 * @param {Film} film
 */
export function clockOf(film) {
  if (!clocks.has(film.scene)) clocks.set(film.scene, new Clock(film));
  return clocks.get(film.scene);
}

export class Clock {
  /** name: its name in the address; begins: its time unless the address has one. */
  constructor(film, name = film.scene, begins = 0) {
    this.scene = film.scene;
    this.name = name;
    this.end = film.end;
    this.time = Math.min(Math.max(state.t[name] ?? begins, 0), this.end);
    this.playing = false;
    this.followers = new Set();
    this.rate = this.end > 3 && this.end < 12 ? 1 : this.end / PLAYS_S;
  }

  set(time) {
    this.time = Math.min(Math.max(time, 0), this.end);
    for (const act of this.followers) act();
  }

  /** Set the time by the reader's hand: it becomes part of the address. */
  choose(time) {
    this.pause();
    this.set(time);
    choose({ t: { ...state.t, [this.name]: this.time } });
  }

  play() {
    if (this.playing) return;
    this.playing = true;
    if (this.time >= this.end) this.set(0);
    let before = performance.now();
    const step = (now) => {
      if (!this.playing) return;
      const time = this.time + ((now - before) / 1000) * this.rate;
      before = now;
      this.set(time > this.end ? 0 : time);
      requestAnimationFrame(step);
    };
    requestAnimationFrame(step);
    this.set(this.time);
  }

  pause() {
    this.playing = false;
    for (const act of this.followers) act();
  }
}

/** How fast it plays, in words. */
function paceOf(clock) {
  if (clock.rate === 1) return "real time";
  return clock.rate < 1 ? `${figure(1 / clock.rate, 2)} times slower` : `${figure(clock.rate, 2)} times faster`;
}

/**
 * Put a film's stage with its controls into host.
 * @param {Element} host
 * @param {Film} film
 * @param {object} options
 * @param {string} options.id its address on the page
 * @param {() => string[]} options.ghosts contestants that are drawn beside the truth
 * @param {string} options.label what it shows, for screen readers
 * @param {boolean} [options.alone] draw one contestant solid, without the truth
 * @param {boolean} [options.controls]
 * @param {boolean} [options.autoplay]
 * @param {Clock} [options.clock]
 */
export function player(host, film, { id, ghosts, label, alone = false, controls = true, autoplay = false, clock = clockOf(film) }) {
  const canvas = make("canvas", { id, class: "stage", role: "img", "aria-label": label });
  host.append(canvas);
  let inView = false;
  const moment = () => ({ film, time: clock.time, names: ghosts(), magnified: alone ? 1 : state.mag, alone });
  const paint = () => {
    if (inView || !clock.playing) canvas.seen = drawMoment(canvas, moment());
  };
  const asSvg = () => {
    const pen = new SvgPen(canvas.clientWidth, canvas.clientHeight);
    drawWith(pen, canvas.clientWidth, canvas.clientHeight, moment());
    return pen.svg;
  };
  new IntersectionObserver((entries) => {
    inView = entries[entries.length - 1].isIntersecting;
    if (!inView && autoplay) clock.pause();
    else if (inView && autoplay && !reducedMotion.matches && !state.t[clock.name]) clock.play();
    paint();
  }).observe(canvas);
  clock.followers.add(paint);
  const tools = figureTools(id, asSvg);
  if (controls) host.append(filled(controlsOf(clock, film), {}, [tools]));
  else host.append(tools);
  follow(["show", "tol", "mag"], paint);
  whenThemeChanges(paint);
  new ResizeObserver(paint).observe(canvas);
  return {
    canvas,
    stop() {
      clock.followers.delete(paint);
    },
  };
}

function controlsOf(clock, film) {
  const play = make("button", { type: "button", class: "play", click: () => (clock.playing ? rest() : clock.play()) });
  const rest = () => {
    clock.pause();
    clock.choose(clock.time);
  };
  const slider = make("input", {
    type: "range",
    class: "time",
    min: 0,
    max: clock.end,
    step: "any",
    "aria-label": `Time in ${clock.scene}, seconds`,
    input: () => clock.choose(Number(slider.value)),
    keydown: (event) => {
      const way = { ArrowLeft: -1, ArrowRight: 1 }[event.key];
      if (!way) return;
      event.preventDefault();
      clock.choose(clock.time + (way * clock.end) / 72);
    },
  });
  const clockText = make("output", { class: "clock" });
  const magnified = make(
    "select",
    { "aria-label": "Magnify deviations", change: () => choose({ mag: Number(magnified.value) }) },
    [1, 10, 100, 1000].map((times) => make("option", { value: times }, `deviations ×${times}`)),
  );
  const update = () => {
    play.textContent = clock.playing ? "❚❚" : "▶";
    play.setAttribute("aria-label", clock.playing ? "Pause" : "Play");
    slider.value = clock.time;
    slider.setAttribute("aria-valuetext", `${figure(clock.time, 3)} s`);
    clockText.textContent = `${clock.time.toFixed(clock.end < 1 ? 3 : 2)} s`;
  };
  clock.followers.add(update);
  update();
  follow(["mag"], () => (magnified.value = state.mag));
  follow(["t"], () => {
    if (!clock.playing && clock.name in state.t && state.t[clock.name] !== clock.time) clock.set(state.t[clock.name]);
  });
  return make("div", { class: "controls" }, play, slider, clockText, film.runs.size ? magnified : "", make("span", { class: "note" }, paceOf(clock)));
}
