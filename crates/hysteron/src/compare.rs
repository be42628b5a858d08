//! Comparison of model structures on records.

use std::ops::ControlFlow;
use std::time::{Duration, Instant};

use hysteron_identify::structure::{Candidate, Selection, compare_from};
use hysteron_identify::{CampaignRecord, Compared, Event, IdentifyError, Options, Searches, Stop, Watch};
use hysteron_model::record::{ChannelChoice, Record};
use serde::{Serialize, Serializer};

use crate::identify::maker;
use crate::{Error, Fit, Report};

/// Builder of a comparison of structures by their simulation error on records, or parts of them, that are
/// held out in turn (cross-validation).
pub struct Compare<'a> {
    records: &'a [Record],
    candidates: Vec<Candidate>,
    quick: bool,
    limit: Option<Duration>,
    channels: ChannelChoice,
    options: Options,
    watch: Watch<'a>,
    stop: Stop,
    resume: Option<Searches>,
}

impl<'a> Compare<'a> {
    /// A comparison on these records of one device.
    pub fn new(records: &'a [Record]) -> Self {
        Self {
            records,
            candidates: Vec::new(),
            quick: false,
            limit: None,
            channels: ChannelChoice::default(),
            options: Options::default(),
            watch: Watch::silent(),
            stop: Stop::new(),
            resume: None,
        }
    }

    /// Structures to compare; default: a search by successive improvement of the best so far.
    #[must_use]
    pub fn candidates(mut self, candidates: impl IntoIterator<Item = Candidate>) -> Self {
        self.candidates = candidates.into_iter().collect();
        self
    }

    /// Without given candidates: one pass of the search, through the commonest structures.
    #[must_use]
    pub fn quick(mut self) -> Self {
        self.quick = true;
        self
    }

    /// Ends after this time with what is finished by then.
    #[must_use]
    pub fn within(mut self, limit: Duration) -> Self {
        self.limit = Some(limit);
        self
    }

    /// The records are consecutive parts of one run on one clock: each part is held out in turn.
    #[must_use]
    pub fn continued(mut self) -> Self {
        self.options.continued = true;
        self
    }

    /// Names of the input and the output column; default: recognised among the channels.
    #[must_use]
    pub fn columns(mut self, input: impl Into<String>, output: impl Into<String>) -> Self {
        self.channels = ChannelChoice { input: Some(input.into()), output: Some(output.into()) };
        self
    }

    /// Callback for progress; it may stop the comparison, which then holds the finished candidates.
    #[must_use]
    pub fn watch(mut self, told: impl FnMut(&Event<'_>) -> ControlFlow<()> + Send + 'a) -> Self {
        self.watch = Watch::new(told);
        self
    }

    /// Handle that stops the comparison from another thread.
    #[must_use]
    pub fn stop(mut self, stop: &Stop) -> Self {
        self.stop = stop.clone();
        self
    }

    /// Goes on with the candidates that an interrupted comparison of the same records and options finished
    /// ([`Event::searches`]); the result is the same.
    #[must_use]
    pub fn resume(mut self, searches: Searches) -> Self {
        self.resume = Some(searches);
        self
    }

    /// Runs the comparison.
    ///
    /// # Errors
    /// [`Error::Model`] for records that cannot be used; [`Error::Identify`] where they cannot rank
    /// structures, with advice on what to measure.
    pub fn run(self) -> Result<Comparison, Error> {
        let begun = Instant::now();
        let record =
            |record: &Record| Ok(CampaignRecord { data: record.input_output(&self.channels)?, role: None });
        let campaign: Vec<CampaignRecord> = self.records.iter().map(record).collect::<Result<_, Error>>()?;
        let selection = Selection::of(&self.candidates, self.quick);
        let watch = self.watch.stopped_by(&self.stop);
        let found = match self.limit {
            None => compare_from(&campaign, selection, &self.options, &watch, self.resume)?,
            Some(limit) => {
                let watch = watch.within(limit, move || begun.elapsed());
                compare_from(&campaign, selection, &self.options, &watch, self.resume)?
            }
        };
        let found = Compared::new(found, &campaign, Vec::new(), &move || begun.elapsed());
        Ok(Comparison { found, campaign })
    }
}

/// Structures in the order of their error on held-out records; its JSON is the output of
/// `hysteron compare --json`.
#[derive(Clone, Debug)]
pub struct Comparison {
    found: Compared,
    campaign: Vec<CampaignRecord>,
}

impl Serialize for Comparison {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        self.found.serialize(serializer)
    }
}

impl Comparison {
    /// The structure with the smallest error, or a simpler one within one standard error of it; `None` where
    /// none was finished.
    pub fn preferred(&self) -> Option<Candidate> {
        let comparison = &self.found.comparison;
        Some(comparison.entries[comparison.ranking.as_ref()?.preferred].candidate)
    }

    /// The preferred structure, identified from all samples of all records.
    ///
    /// # Errors
    /// [`Error::Identify`].
    pub fn identify(&self) -> Result<Fit, Error> {
        let (_, fit) = self
            .found
            .identify_preferred(&self.campaign, &Watch::silent(), &maker())
            .ok_or(IdentifyError::Stopped)?;
        Ok(Fit::from(fit?))
    }

    /// The comparison in full.
    pub fn core(&self) -> &Compared {
        &self.found
    }

    /// The report of the comparison.
    pub fn report(&self) -> Report {
        Report(hysteron_report::comparison::page(&self.found, &maker()))
    }
}
