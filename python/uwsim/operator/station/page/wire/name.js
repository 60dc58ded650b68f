// The name by which the others at the station know this page.

const STORED = 'uwsim.name';

export const keptName = () => localStorage.getItem(STORED) ?? `Pilot ${100 + Math.floor(Math.random() * 900)}`;

export const keepName = (name) => localStorage.setItem(STORED, name);
