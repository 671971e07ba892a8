import { html } from "htl";

import { hertz, number, percent, seconds } from "./format.js";
import { slider } from "./slider.js";

// Any mode swings once in so many seconds, at whatever frequency it does so in truth.
const period = 1.25;
const still = matchMedia("(prefers-reduced-motion: reduce)");

// Chooses a mode of what a viewer shows, colours it, and moves it in slow motion. facts(mode): {hertz, cents,
// t60, largest: displacement [m] after the last strike, or null}; chosen(mode or null) after it was chosen.
export class Swing {
  constructor(viewer, { facts, chosen }) {
    this.viewer = viewer;
    this.facts = facts;
    this.chosen = chosen;
    this.share = 0.12;
    this.select = html`<select></select>`;
    this.select.onchange = () => this.choose(this.select.value === "" ? null : Number(this.select.value));
    this.button = html`<button type="button">Play</button>`;
    this.button.onclick = () => (this.isPlaying ? this.pause() : this.play());
    this.text = html`<p class="note" aria-live="polite"></p>`;
    this.deflection = slider({
      label: "Largest deflection",
      low: 0.01,
      high: 0.4,
      value: this.share,
      format: (share) => `${percent(share, 2)} of the radius`,
      moved: (share) => {
        this.share = share;
        if (!this.isPlaying) this.hold();
      },
      changed: () => this.tell(),
    });
    this.more = html`<div class="controls">${this.deflection}<p class="buttons">${this.button}</p></div>`;
    this.element = html`<div class="swing"><label>Show mode ${this.select}</label>${this.more}${this.text}</div>`;
    new IntersectionObserver((entries) => (this.isSeen = entries.at(-1).isIntersecting)).observe(viewer.element);
  }

  // Modes of the object that the viewer shows now.
  show(object) {
    this.pause();
    this.object = object;
    this.mode = null;
    this.list();
    this.tell();
  }

  // Their frequencies, which go with the settings.
  list() {
    const count = this.object.eigenvalues.length;
    this.select.replaceChildren(
      html`<option value="">none</option>`,
      ...Array.from({ length: count }, (_, mode) => html`<option value=${mode}>${mode + 1}: ${hertz(this.facts(mode).hertz)}</option>`),
    );
    this.select.value = this.mode ?? "";
  }

  choose(mode) {
    this.pause();
    this.mode = mode;
    this.select.value = mode ?? "";
    this.viewer.color(mode);
    if (this.moves()) {
      if (still.matches) this.hold();
      else this.play();
    }
    this.tell();
    this.chosen(mode);
  }

  moves() {
    return this.mode !== null && this.mode < this.object.moving.length && Boolean(this.viewer.renderer);
  }

  play() {
    const begun = performance.now() - 1000 * (this.phase ?? 0) * period;
    const step = (now) => {
      this.phase = (((now - begun) / 1000 / period) % 1 + 1) % 1;
      if (this.isSeen !== false) this.viewer.deflect(this.share * Math.sin(2 * Math.PI * this.phase));
      this.frame = requestAnimationFrame(step);
    };
    this.frame = requestAnimationFrame(step);
    this.isPlaying = true;
    this.button.textContent = "Pause";
  }

  // Stays where it is.
  pause() {
    cancelAnimationFrame(this.frame);
    this.isPlaying = false;
    this.button.textContent = "Play";
  }

  // At its largest, as if a quarter of a swing had passed.
  hold() {
    if (!this.moves()) return;
    this.phase = 0.25;
    this.viewer.deflect(this.share);
  }

  tell() {
    this.more.hidden = !this.moves();
    this.text.hidden = this.mode === null;
    if (this.mode === null) return;
    const { hertz: frequency, cents, t60, largest } = this.facts(this.mode);
    const known = cents === null ? "no error estimate" : `± ${number(cents, 2)} cents (estimated)`;
    const moving = this.moves()
      ? ` One swing takes ${number(period)} s here, ${number(frequency * period, 3)} times as long as in truth.${this.exaggeration(largest)}`
      : ` This page has the motion of the lowest ${this.object.moving.length} modes alone.`;
    this.text.textContent = `Mode ${this.mode + 1}: ${hertz(frequency)} ${known}, T60 ${seconds(t60)}. Red goes outwards when blue goes inwards.${moving}`;
  }

  exaggeration(largest) {
    if (!(largest > 0)) return " Strike it to know how much larger than in truth it is drawn.";
    return ` Drawn ${number((this.share * this.viewer.radius * this.object.scale()) / largest, 2)} times larger than after the last strike.`;
  }
}
