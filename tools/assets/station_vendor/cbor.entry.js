// The build without eval: the page's content security policy forbids it.
export { Decoder } from './node_modules/cbor-x/dist/decode-no-eval.cjs';
