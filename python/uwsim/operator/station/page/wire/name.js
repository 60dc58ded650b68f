// The name of this page as shown to the other members of the station.
import { STRINGS } from '../strings.js';

const WORDS = STRINGS.wire;

const STORED = 'uwsim.name';

export const keptName = () => localStorage.getItem(STORED) ?? WORDS.pilot(100 + Math.floor(Math.random() * 900));

export const keepName = (name) => localStorage.setItem(STORED, name);
