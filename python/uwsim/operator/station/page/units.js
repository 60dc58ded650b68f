// Lengths in the pilot's unit: metres, feet or fathoms. The wire and all files stay in metres.
const STORED = 'uwsim.units';
const METRES = { metres: ['m', 1], feet: ['ft', 0.3048], fathoms: ['fm', 1.8288] }; // international foot; 6 feet
export const UNITS = Object.keys(METRES);

export function unit() {
  const kept = globalThis.localStorage?.getItem(STORED);
  return kept && UNITS.includes(kept) ? kept : 'metres';
}

export const setUnit = (name) => localStorage.setItem(STORED, name);
export const unitName = (name = unit()) => METRES[name][0];
export const inUnit = (length_m, name = unit()) => length_m / METRES[name][1];
