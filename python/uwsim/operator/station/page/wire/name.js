// The name of this page as shown to the other members of the station.

const STORED = 'uwsim.name';

// A page that is loaded again keeps its name, by which it gets the controls back that it lost with its connection.
export function keptName() {
  const own = localStorage.getItem(STORED) ?? sessionStorage.getItem(STORED);
  const name = own ?? `Pilot ${100 + Math.floor(Math.random() * 900)}`;
  sessionStorage.setItem(STORED, name);
  return name;
}

export const keepName = (name) => localStorage.setItem(STORED, name);
