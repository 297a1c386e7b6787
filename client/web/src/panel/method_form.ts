import type { Method, Options, Parameter, Value } from '../api/types';
import { byId, element } from '../dom';
import { label } from '../text';

/** What /v1/methods describes, as a form: the first parameter of the method at once, all others folded away. */
export class MethodForm {
  private methods: Method[] = [];
  private readonly fields = new Map<string, { parameter: Parameter; input: HTMLInputElement | HTMLSelectElement; box: HTMLElement }>();
  private readonly choice = byId<HTMLSelectElement>('method');

  constructor(private readonly changed: () => void) {
    this.choice.onchange = () => this.show(this.choice.value);
    byId<HTMLButtonElement>('defaults').onclick = () => this.show(this.choice.value);
  }

  get ready(): boolean { return this.methods.length > 0; }

  fill(methods: Method[]): void {
    this.methods = methods;
    this.choice.replaceChildren(...methods.map(({ name }, k) => element('option', { value: name }, k === 0 ? `${name} (chooses by itself)` : name)));
    this.show(methods[0].name);
  }

  /** The method and what differs from its defaults. */
  options(): Options {
    const parameters: Record<string, Value> = {};
    for (const [name, { parameter, input }] of this.fields) {
      const value = parameter.kind === 'PARAMETER_KIND_CHOICE' ? input.value : Number(input.value);
      if (value !== parameter.defaultValue) parameters[name] = value;
    }
    return { method: this.choice.value, parameters };
  }

  set({ method, parameters }: Options): void {
    this.show(method);
    for (const [name, value] of Object.entries(parameters)) {
      const field = this.fields.get(name);
      if (!field) continue;
      field.input.value = String(value);
      field.input.dispatchEvent(new Event('input'));
    }
  }

  private show(name: string): void {
    const method = this.methods.find((each) => each.name === name);
    if (!method) return;
    this.choice.value = name;
    byId('method-name').textContent = method.name;
    byId('method-summary').textContent = method.summary;
    byId('method-reference').textContent = `From: ${method.reference}`;
    this.fields.clear();
    const [first, ...others] = method.parameters.map((parameter) => this.field(parameter));
    byId('first-parameter').replaceChildren(first);
    byId('parameters').replaceChildren(...others);
    this.changed();
  }

  private field(parameter: Parameter): HTMLElement {
    const { name, kind, defaultValue, unit } = parameter;
    const id = `parameter-${name}`;
    const step = sliderStep(parameter), slides = step !== undefined;
    const input = kind === 'PARAMETER_KIND_CHOICE' ? this.select(parameter) : this.number(parameter, step);
    Object.assign(input, { id, value: String(defaultValue) });
    input.setAttribute('aria-describedby', `${id}-help`);
    const shown = slides ? element('output', { htmlFor: id }, String(defaultValue)) : null;
    const words = unit && unit !== '1' ? element('span', { className: 'help' }, unit.replaceAll('_', ' ')) : null;
    const box = element('div', { className: 'field' },
      element('div', { className: 'head' }, element('label', { for: id, className: 'label' }, label(name)), shown ?? words),
      input, element('p', { className: 'help', id: `${id}-help` }, help(parameter, slides)));
    const update = () => {
      if (shown) shown.textContent = input.value;
      box.classList.toggle('changed', input.value !== String(defaultValue));
      this.changed();
    };
    input.addEventListener('input', update);
    this.fields.set(name, { parameter, input, box });
    return box;
  }

  private select({ choices }: Parameter): HTMLSelectElement {
    return element('select', {}, ...choices.map((choice) => element('option', { value: choice }, choice.replaceAll('_', ' '))));
  }

  private number({ kind, minimum, maximum }: Parameter, slider?: number): HTMLInputElement {
    const step = slider ?? (kind === 'PARAMETER_KIND_INTEGER' ? 1 : 'any');
    return element('input', { type: slider ? 'range' : 'number', min: String(minimum), max: String(maximum), step: String(step), required: true });
  }
}

/** The step of a slider for short ranges; none where a slider could not stand on the default. */
function sliderStep({ kind, minimum, maximum, defaultValue }: Parameter): number | undefined {
  if (kind !== 'PARAMETER_KIND_NUMBER' || maximum - minimum > 10) return undefined;
  const step = maximum - minimum > 2 ? 0.05 : 0.01;
  const steps = (Number(defaultValue) - minimum) / step;
  return Math.abs(steps - Math.round(steps)) < 1e-9 ? step : undefined;
}

function help({ description, minimum, maximum, kind, defaultValue }: Parameter, slides: boolean): string {
  if (kind === 'PARAMETER_KIND_CHOICE') return description;
  const range = maximum >= 1e9 ? `from ${minimum}` : `${minimum} to ${maximum}`;
  return slides ? description : `${description} Range: ${range}; default: ${defaultValue}.`;
}
