// The name of this page for the others at the station.

const STORED = 'uwsim.name';

export const keptName = () => localStorage.getItem(STORED) ?? `Pilot ${100 + Math.floor(Math.random() * 900)}`;

export const keepName = (name) => localStorage.setItem(STORED, name);
