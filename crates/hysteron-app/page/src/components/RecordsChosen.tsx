// Records chosen for an operation: check boxes, so that it can be done by key.
import type { RecordEntry } from '../api/types';
import { fileName } from '../format';

export function RecordsChosen(props: {
  label: string;
  records: RecordEntry[];
  chosen: string[];
  choose: (ids: string[]) => void;
}) {
  const toggle = (id: string): void =>
    props.choose(
      props.chosen.includes(id) ? props.chosen.filter((other) => other !== id) : [...props.chosen, id],
    );
  return (
    <fieldset class="f">
      <legend>{props.label}</legend>
      <div class="row wrap">
        {props.records.map((record) => (
          <label class="row" key={record.id}>
            <input
              type="checkbox"
              checked={props.chosen.includes(record.id)}
              onChange={() => toggle(record.id)}
            />
            {fileName(record.id)}
          </label>
        ))}
      </div>
    </fieldset>
  );
}
