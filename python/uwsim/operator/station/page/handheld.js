// Screens that are held in hands: a finger points, or the window is as narrow as a phone. The styles read the class
// is-hand-held, the scripts these functions; the event 'screen' follows each change.
const HAND_HELD = matchMedia('(pointer: coarse), (max-width: 32.5em)');
const NARROW = matchMedia('(max-width: 32.5em)');
const LEVEL = matchMedia('(orientation: landscape)'); // else, the sticks lie over the small views

export const isHandheld = () => HAND_HELD.matches;
export const isNarrow = () => NARROW.matches;

const BAR_REM = 2.875; // the folded bar
const FOOT_REM = 2.125; // the picture's name and tools at its lower edge
const STICKS_REM = 7.75;
const BAR_WIDTH_REM = 15.75; // with the longest name of a pilot

/** The margins of a large picture that other things lie over [rem]: head and foot over its middle, shoulders and corners
 * beside it, at its upper and lower edge.
 * @type {(isFlown: boolean, isUnfolded: boolean) => { head: number, shoulders: number, foot: number, corners: number }}
 */
export function covered(isFlown, isUnfolded) {
  if (!isHandheld()) return { head: 0, shoulders: 0, foot: 0, corners: 0 };
  if (isUnfolded) return { head: 0, shoulders: 0, foot: FOOT_REM, corners: 0 };
  // On a narrow screen, one above the other.
  const [head, shoulders, foot] = isNarrow() ? [BAR_REM, 0, FOOT_REM] : [0, BAR_WIDTH_REM, 0];
  return { head, shoulders, foot, corners: isFlown && LEVEL.matches ? STICKS_REM : 0 };
}

function apply() {
  document.documentElement.classList.toggle('is-hand-held', isHandheld());
  dispatchEvent(new Event('screen'));
}

HAND_HELD.addEventListener('change', apply);
NARROW.addEventListener('change', apply);
apply();
