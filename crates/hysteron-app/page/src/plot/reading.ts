// The values at a sample, as the reading above a figure says them.
import { quantityText, significant, unitText } from '../format';
import type { Spec } from './spec';

export function reading(spec: Spec, index: number): string {
  const leading = spec.lines[0];
  if (!leading || index < 0) return '';
  const across = leading.x[index];
  if (across == null) return '';
  const values: string[] = [];
  for (const line of spec.lines) {
    const at = line === leading ? index : line.x.length === leading.x.length ? index : -1;
    const y = at < 0 ? null : line.y[at];
    if (y == null) continue;
    values.push((line.name ? `${line.name} ` : '') + significant(y, 4));
  }
  const x =
    spec.x.unit === 's'
      ? quantityText(across, 's', 5)
      : `${significant(across, 4)} ${unitText(spec.x.unit)}`;
  return `${x.trim()}: ${values.join(', ')} ${unitText(spec.y.unit)}`.trim();
}
