export { html, render } from 'htm/preact';
export { signal } from '@preact/signals';
