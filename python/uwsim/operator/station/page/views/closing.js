// Estimates the time to contact from successive ranges.

const SMOOTH_S = 0.6; // time constant of the closing speed
const GAP_S = 2; // gap after which earlier ranges are ignored
const SLOWEST_M_S = 0.03; // lower speeds are indistinguishable from noise
export const WARN_S = 5;

export class Closing {
  #range_m = NaN;
  #time_s = NaN;
  #speed_m_s = NaN; // closing speed
  time_s = Infinity; // time to contact; Infinity while nothing is being approached or in range

  // Process a range [m] (NaN or Infinity for none) measured at a simulated time [s].
  add(range_m, time_s) {
    const step_s = time_s - this.#time_s;
    if (step_s === 0) return this.time_s;
    if (!Number.isFinite(range_m) || !(step_s > 0 && step_s < GAP_S)) this.#speed_m_s = NaN;
    else {
      const speed_m_s = (this.#range_m - range_m) / step_s;
      const share = 1 - Math.exp(-step_s / SMOOTH_S);
      if (Number.isFinite(speed_m_s))
        this.#speed_m_s = Number.isFinite(this.#speed_m_s)
          ? this.#speed_m_s + share * (speed_m_s - this.#speed_m_s)
          : share * speed_m_s;
    }
    [this.#range_m, this.#time_s] = [range_m, time_s];
    this.time_s = this.#speed_m_s > SLOWEST_M_S ? range_m / this.#speed_m_s : Infinity;
    return this.time_s;
  }
}

// Return the next contact among named ranges, { name, time_s }, or null. closings: a Map from name to Closing.
export function soonest(closings) {
  let found = null;
  for (const [name, { time_s }] of closings)
    if (time_s < WARN_S && time_s < (found?.time_s ?? Infinity)) found = { name, time_s };
  return found;
}
