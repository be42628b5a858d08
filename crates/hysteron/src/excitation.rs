//! Drive waveforms for an identification campaign.
