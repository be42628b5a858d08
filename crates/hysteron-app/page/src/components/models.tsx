// The model that a room is about: by the URL, else the newest.
import { useResource } from '../api/resource';
import type { ModelEntry } from '../api/types';
import { go, route } from '../route';
import { useSignal } from '../signal';
import { Lacking } from './words';
import { address } from '../route';

export function useModel(): { models: ModelEntry[] | undefined; model: ModelEntry | undefined } {
  const { query } = useSignal(route);
  const models = useResource<ModelEntry[]>('models').value?.filter((model) => !model.error);
  const whole = models?.filter((model) => !model.interrupted);
  const newest = whole?.sort((a, b) => b.modified.localeCompare(a.modified))[0];
  return { models, model: models?.find((model) => model.id === query.get('m')) ?? newest };
}

/** How a model is called in a list. */
export function modelName(model: ModelEntry): string {
  const name = model.device ? `${model.device}/${model.name}` : model.name;
  return model.interrupted ? `${name} (best so far of an interrupted fit)` : name;
}

export function ModelChoice({ models, model }: { models: ModelEntry[]; model: ModelEntry }) {
  return (
    <select
      aria-label="Model"
      value={model.id}
      onChange={(event) => go({ m: event.currentTarget.value, rec: null })}
    >
      {models.map((other) => (
        <option key={other.id} value={other.id}>
          {modelName(other)}
        </option>
      ))}
    </select>
  );
}

export function NoModel() {
  return (
    <Lacking
      title="No model yet"
      action={
        <a class="btn primary" href={address({}, 'identify')}>
          Identify a model
        </a>
      }
    >
      Identify one first, from a record of yours or from an example.
    </Lacking>
  );
}
