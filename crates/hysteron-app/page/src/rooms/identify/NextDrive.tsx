// The drive after whose record the model is known best for a purpose.
import { path } from '../../api/client';
import { Operation } from '../../components/Operation';

export function NextDrive({ model, device }: { model: string; device: string }) {
  const at = `${path('models', model)}/design`;
  return (
    <Operation
      name="design"
      title="Design the next drive"
      about="Put together from loops, reversals, sines, sweeps, multisines and holds within range and slew rate, such that the standard error of what it is for becomes least; compared with a loop and a sweep of the same length."
      model={model}
      at={at}
      request={{}}
      verb="Design the drive"
      save={{ name: device ? `${device}/next.csv` : 'next.csv', always: true }}
    />
  );
}
