// The small views, one after the other, with a rest in between that is a multiple of how long the last one took: however
// slow the machine is, most of its time is left to the large view.

const REST = 3; // times as long
const LEAST_REST_MS = 100;
const PATIENCE_MS = 3000; // with one that does not come

export class Previews {
  #streams = []; // { picture, topic }, the next one first
  #current = null;
  #begunMs = 0;
  #timer = 0;
  #drawn = () => this.#rest();

  // streams: all that are small now; none while nobody looks.
  show(streams) {
    this.#streams = streams;
    if (this.#current && !streams.some(({ topic }) => topic === this.#current.topic)) this.#end();
    if (!this.#current) this.#next();
  }

  #next() {
    clearTimeout(this.#timer);
    const stream = this.#streams.shift();
    if (!stream) return;
    this.#streams.push(stream);
    this.#current = stream;
    this.#begunMs = performance.now();
    stream.picture.addEventListener('drawn', this.#drawn);
    stream.picture.show(stream.topic, {});
    this.#timer = setTimeout(() => this.#rest(), PATIENCE_MS);
  }

  #rest() {
    const restMs = Math.max(LEAST_REST_MS, REST * (performance.now() - this.#begunMs));
    this.#end();
    this.#timer = setTimeout(() => this.#next(), restMs);
  }

  #end() {
    clearTimeout(this.#timer);
    const { picture, topic } = this.#current;
    this.#current = null;
    picture.removeEventListener('drawn', this.#drawn);
    if (picture.topic === topic) picture.show(''); // else it is large by now
  }
}
