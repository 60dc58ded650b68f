/** Elements and components from a template, for `render`. */
export function html(strings: TemplateStringsArray, ...values: any[]): any;
export function render(view: any, root: Element): void;
/** A value; components that read it are drawn again when it changes. */
export function signal<T = any>(value: any): { value: T };
