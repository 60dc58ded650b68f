// The small views, refreshed one after the other: the one that has waited longest is next. Each pause is a multiple of
// the time that the last one took, so that most of the time is left for the large view; on a busy machine, where that is
// long, it is bounded.

const REST = 3; // times the duration of the last picture
const LEAST_REST_MS = 100;
const MOST_REST_MS = 1000;
const PATIENCE_MS = 8000; // maximum wait for a picture

export class Previews {
  #streams = []; // { picture, topic }
  /** @type {Map<string, number>} */
  #turns = new Map(); // the turn at which a topic was last asked for
  #turn = 0;
  /** @type {{ picture: any, topic: string } | null} */
  #current = null;
  #begunMs = 0;
  #timer = 0;
  #drawn = () => this.#rest();

  // streams: the streams of all small views; none while the page is hidden.
  show(streams) {
    this.#streams = streams;
    if (this.#current && !streams.some(({ topic }) => topic === this.#current?.topic)) this.#end();
    if (!this.#current) this.#next();
  }

  #next() {
    clearTimeout(this.#timer);
    const turnOf = ({ topic }) => this.#turns.get(topic) ?? 0;
    const [stream] = this.#streams.toSorted((a, b) => turnOf(a) - turnOf(b));
    if (!stream) return;
    this.#turns.set(stream.topic, (this.#turn += 1));
    this.#current = stream;
    this.#begunMs = performance.now();
    stream.picture.addEventListener('drawn', this.#drawn);
    stream.picture.show(stream.topic, {});
    this.#timer = setTimeout(() => this.#rest(), PATIENCE_MS);
  }

  #rest() {
    const tookMs = performance.now() - this.#begunMs;
    const restMs = Math.min(Math.max(LEAST_REST_MS, REST * tookMs), MOST_REST_MS);
    this.#end();
    this.#timer = setTimeout(() => this.#next(), restMs);
  }

  #end() {
    clearTimeout(this.#timer);
    if (!this.#current) return;
    const { picture, topic } = this.#current;
    this.#current = null;
    picture.removeEventListener('drawn', this.#drawn);
    if (picture.topic === topic) picture.show('');
  }
}
