// Gives the page's modules that run without a server the messages.js that the station makes. node --import made.mjs
import { registerHooks } from 'node:module';

const made = { url: process.env.MESSAGES, format: 'module', shortCircuit: true };
registerHooks({ resolve: (name, of, next) => (name.endsWith('/messages.js') ? made : next(name, of)) });
