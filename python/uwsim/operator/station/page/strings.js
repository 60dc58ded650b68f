// The words that the page shows, by topic, for translation: a value is text, or a function that puts values into text.
export const STRINGS = {
  sonar: {
    ahead: 'ahead',
    amber: 'Amber',
    auto: 'auto',
    controls: 'Sonar picture',
    cursor: 'Range and bearing at the cursor',
    freeze: 'Freeze',
    frozen: (seconds) => `Frozen for ${seconds} s`,
    gain: 'Gain',
    green: 'Green',
    grey: 'Grey',
    ice: 'Ice',
    less: (what) => `Less ${what}`,
    more: (what) => `More ${what}`,
    noCursor: 'Point at the picture',
    palette: 'Palette',
    port: 'port',
    range: 'Range',
    reading: (range, unit, bearing) => `${range} ${unit}, ${bearing}`,
    starboard: 'starboard',
  },
};
