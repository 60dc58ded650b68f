import { STRINGS } from '../strings.js';
import * as messages from './messages.js';
import { accepted } from './rosbridge.js';
import { Station } from './station.js';

// The station with parameters accessed through the instructor's own services.
export class InstructorStation extends Station {
  isAdmitted = false;
  /** @type {Record<string, number>} */
  visibility_m = {}; // by type of water

  get isPilot() {
    return this.isAdmitted;
  }

  // Present the instructor's token. Return why it is refused, or ''.
  async supervise(token) {
    this.isAdmitted = false;
    if (!token) return STRINGS.instructor.noToken;
    try {
      const { success, message } = await messages.supervise(this.bridge, { token });
      this.isAdmitted = success;
      return success ? '' : message;
    } catch (error) {
      return error.message;
    }
  }

  instruct(action, args = {}) {
    return messages.instruct(this.bridge, { action, args });
  }

  command(name, args) {
    return this.instruct('command', { name, args });
  }

  async described() {
    const found = await accepted(messages.parameters(this.bridge));
    this.visibility_m = found.visibility_m;
    return JSON.parse(found.descriptions_json);
  }

  async parameterNames() {
    return (await this.described()).map(({ name }) => name);
  }

  describeParameters() {
    return this.described();
  }

  async parameterValues() {
    return Object.fromEntries((await this.described()).map(({ name, value }) => [name, value]));
  }

  setParameters(changes) {
    return this.command('set_parameters', { changes });
  }

  resetParameters(name) {
    return this.command('reset_parameters', { name });
  }
}
