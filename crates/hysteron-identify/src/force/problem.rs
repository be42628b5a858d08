//! The force as a problem for `hysteron_optimize`: its nonlinear numbers are searched, the others eliminated.

use hysteron_model::Start;
use hysteron_model::force::{ForceModel, ForceModelError, Motion, Saturation};
use hysteron_model::hysteresis::{Columns, DriveGrid, HysteresisForm};
use hysteron_model::record::{InputOutput, span};
use hysteron_numeric::non_negative_least_squares;
use hysteron_optimize::{Bounds, LeastSquaresProblem, Problem, root_mean_square};

use crate::layout::Role;
use crate::projection::Projection;

/// A record prepared for the fit.
pub(super) struct PreparedRecord<'a> {
    pub data: &'a InputOutput,
    /// Rate of the displacement.
    pub rate: Vec<f64>,
    /// Samples that are fitted, ascending.
    pub fitted: Vec<usize>,
    /// Factor of every row.
    pub weight: f64,
}

impl<'a> PreparedRecord<'a> {
    /// Most samples of a record that are fitted: every k-th of a longer one. All are simulated.
    const MOST_ROWS: usize = 2000;

    pub(super) fn new(data: &'a InputOutput, window_s: f64) -> Result<Self, ForceModelError> {
        let rate = Self::motion_of(data).rate(window_s)?.into_owned();
        let valid: Vec<usize> = (0..data.len()).filter(|&k| data.is_valid(k)).collect();
        let stride = valid.len().div_ceil(Self::MOST_ROWS).max(1);
        let fitted: Vec<usize> = valid.into_iter().step_by(stride).collect();
        let force: Vec<f64> = fitted.iter().map(|&k| data.y[k]).collect();
        let weight = 1.0 / (span(&force) * (fitted.len() as f64).sqrt());
        Ok(Self { data, rate, fitted, weight })
    }

    fn motion_of(data: &InputOutput) -> Motion<'_> {
        Motion { x: &data.u, rate: data.rate.as_deref(), time: &data.time }
    }

    pub(super) fn motion(&self) -> Motion<'_> {
        Self::motion_of(self.data)
    }

    /// Appends the fitted samples of a signal, weighted.
    fn append(&self, rows: &mut Vec<f64>, signal: impl Fn(usize) -> f64) {
        rows.extend(self.fitted.iter().map(|&k| self.weight * signal(k)));
    }
}

/// Numbers of the force other than weights and coefficients.
pub(super) struct ForceLayout {
    pub shape: Vec<Role>,
    /// Viscous coefficient, where it is held.
    pub viscous: Option<f64>,
    /// Force at which the saturating force saturates, where it is held.
    pub saturating_force: Option<f64>,
    pub saturating_rate: Role,
    pub saturating_reach: Role,
}

pub(super) struct ForceProblem<'a> {
    pub records: Vec<PreparedRecord<'a>>,
    pub form: HysteresisForm,
    pub degree: usize,
    pub rate_window_s: f64,
    pub layout: ForceLayout,
    pub bounds: Bounds,
    /// Signs with which the columns of the hysteresis dissipate.
    orientation: Vec<f64>,
    target: Vec<f64>,
    viscous: Vec<f64>,
    /// Constant and powers of the displacement.
    free: Projection,
}

/// Everything eliminated at a candidate.
pub(super) struct Eliminated {
    residual: Vec<f64>,
    model: Option<ForceModel>,
}

impl<'a> ForceProblem<'a> {
    pub(super) fn new(
        records: Vec<PreparedRecord<'a>>,
        (form, degree): (HysteresisForm, usize),
        rate_window_s: f64,
        (layout, bounds): (ForceLayout, Bounds),
        example: &[f64],
    ) -> Self {
        let mut problem = Self {
            free: Projection::new(0, 0),
            orientation: vec![1.0; form.columns()],
            target: Vec::new(),
            viscous: Vec::new(),
            records,
            form,
            degree,
            rate_window_s,
            layout,
            bounds,
        };
        problem.target = problem.rows(|record, k| record.data.y[k]);
        problem.viscous = problem.rows(|record, k| record.rate[k]);
        let mut free = Projection::new(problem.target.len(), degree + 1);
        for power in 0..=degree {
            let rows = problem.rows(|record, k| record.data.u[k].powi(power as i32));
            free.push(|column| column.copy_from_slice(&rows));
        }
        problem.free = free;
        let columns = problem.hysteresis_columns(example).unwrap_or_default();
        problem.orientation = columns.iter().map(|column| problem.dissipating_sign(column)).collect();
        problem
    }

    fn rows(&self, signal: impl Fn(&PreparedRecord<'a>, usize) -> f64) -> Vec<f64> {
        let mut rows = Vec::new();
        self.records.iter().for_each(|record| record.append(&mut rows, |k| signal(record, k)));
        rows
    }

    /// Sign of a force along `column` that takes energy from the motion; what it shares with a spring takes
    /// none.
    fn dissipating_sign(&self, column: &[f64]) -> f64 {
        let mut column = column.to_vec();
        self.free.project(&mut column);
        let power: f64 = column.iter().zip(&self.viscous).map(|(h, v)| h * v).sum();
        if power < 0.0 { -1.0 } else { 1.0 }
    }

    /// Columns of the hysteresis family, with its sign.
    fn hysteresis_columns(&self, shape: &[f64]) -> Option<Vec<Vec<f64>>> {
        let mut all = vec![Vec::with_capacity(self.target.len()); self.form.columns()];
        let mut columns = Columns::default();
        for record in &self.records {
            let grid = DriveGrid::new(record.data.sample_rate_hz(), 1, 1);
            let start = Start::AsIdentified;
            self.form.run(shape, grid, &record.data.u, start, None, &mut columns).ok()?;
            for (j, rows) in all.iter_mut().enumerate() {
                let (values, standing) = (columns.values.get(j)?, columns.standing.get(j).unwrap_or(&0.0));
                record.append(rows, |k| self.form.sign() * (values[k] + standing));
            }
        }
        Some(all)
    }

    /// s at the fitted samples.
    fn saturating_column(&self, saturation: &Saturation) -> Option<Vec<f64>> {
        let mut rows = Vec::with_capacity(self.target.len());
        for record in &self.records {
            let shares = saturation.shares(&record.motion(), &record.rate).ok()?;
            record.append(&mut rows, |k| shares[k]);
        }
        Some(rows)
    }

    /// Residual at a candidate, and with `wanted` its model.
    fn eliminate(&self, x: &[f64], wanted: bool) -> Option<Eliminated> {
        let shape: Vec<f64> = self.layout.shape.iter().map(|role| role.value(x)).collect::<Option<_>>()?;
        let (rate, reach) = (self.layout.saturating_rate.value(x)?, self.layout.saturating_reach.value(x)?);
        let unit = Saturation { force: 1.0, rate, reach };
        let mut measured = self.target.clone();
        let mut columns: Vec<Vec<f64>> = Vec::new();
        let mut places: Vec<usize> = Vec::new();
        let oriented = |(column, sign): (Vec<f64>, &f64)| column.into_iter().map(|h| h * sign).collect();
        let hysteresis = self.hysteresis_columns(&shape)?.into_iter().zip(&self.orientation).map(oriented);
        let weights = self.form.columns();
        let all = hysteresis.map(|column| (column, None)).chain([
            (self.viscous.clone(), self.layout.viscous),
            (self.saturating_column(&unit)?, self.layout.saturating_force),
        ]);
        let mut coefficients = vec![0.0; weights + 2];
        for (place, (column, held)) in all.enumerate() {
            match held {
                Some(value) => {
                    coefficients[place] = value;
                    measured.iter_mut().zip(&column).for_each(|(m, c)| *m -= value * c);
                }
                None => {
                    places.push(place);
                    columns.push(column);
                }
            }
        }
        let mut residual = measured.clone();
        self.free.project(&mut residual);
        let mut projected = columns.clone();
        projected.iter_mut().for_each(|column| self.free.project(column));
        let views: Vec<&[f64]> = projected.iter().map(Vec::as_slice).collect();
        let solution = non_negative_least_squares(&views, &residual);
        if solution.iter().any(|c| !c.is_finite()) {
            return None;
        }
        for ((column, projected), c) in columns.iter().zip(&projected).zip(&solution) {
            residual.iter_mut().zip(projected).for_each(|(r, p)| *r -= c * p);
            measured.iter_mut().zip(column).for_each(|(m, p)| *m -= c * p);
        }
        if !wanted {
            return Some(Eliminated { residual, model: None });
        }
        places.iter().zip(&solution).for_each(|(&place, c)| coefficients[place] = *c);
        let free = self.free.coefficients(&measured);
        let (offset, polynomial) = free.split_first()?;
        let (own, of_rate) = coefficients.split_at(weights);
        let own: Vec<f64> = own.iter().zip(&self.orientation).map(|(c, sign)| c * sign).collect();
        let hysteresis = self.form.operator(polynomial.to_vec(), &own, &shape).ok()?;
        let saturation = Saturation { force: of_rate[1], ..unit };
        let model = ForceModel {
            offset: *offset,
            hysteresis,
            viscous: of_rate[0],
            saturating: if saturation.force == 0.0 { Vec::new() } else { vec![saturation] },
            rate_window_s: self.rate_window_s,
        };
        Some(Eliminated { residual, model: Some(model) })
    }

    /// The model at a candidate.
    pub(super) fn model(&self, x: &[f64]) -> Option<ForceModel> {
        self.eliminate(x, true)?.model
    }

    /// Weighted residual of a model at the fitted samples.
    pub(super) fn residual_of(&self, model: &ForceModel) -> Option<Vec<f64>> {
        let mut rows = Vec::with_capacity(self.target.len());
        for record in &self.records {
            let simulated = model.simulate(&record.motion(), Start::AsIdentified).ok()?;
            record.append(&mut rows, |k| record.data.y[k] - simulated[k]);
        }
        Some(rows)
    }
}

impl Problem for ForceProblem<'_> {
    type Workspace = ();

    fn bounds(&self) -> &Bounds {
        &self.bounds
    }

    fn workspace(&self) {}

    fn cost(&self, x: &[f64], (): &mut ()) -> f64 {
        self.eliminate(x, false).map_or(f64::INFINITY, |found| root_mean_square(&found.residual))
    }

    fn identity(&self) -> String {
        let bits = self.target.iter().chain(&self.viscous).map(|value| value.to_bits());
        format!("force {:?} {} {:016x}", self.form, self.degree, crate::fingerprint(bits))
    }
}

impl LeastSquaresProblem for ForceProblem<'_> {
    fn residual_count(&self) -> usize {
        self.target.len()
    }

    fn residuals(&self, x: &[f64], (): &mut (), out: &mut [f64]) -> bool {
        match self.eliminate(x, false) {
            Some(found) => {
                out.copy_from_slice(&found.residual);
                true
            }
            None => false,
        }
    }
}
