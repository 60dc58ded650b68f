export class Decoder {
  constructor(options?: object);
  decode(bytes: Uint8Array): any;
}
