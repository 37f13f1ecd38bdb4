//! Rays that are wanted, and what came of them.

use crate::scene::Arrival;
use glam::Vec3;

/// What one light sends to each sample of a surface.
pub(super) struct Wanted {
    /// Colour that arrives if nothing is in the way; `None` where no ray is needed.
    pub sent: Vec<Option<Vec3>>,
    /// What does arrive.
    pub arrived: Vec<Option<Arrival>>,
    /// Samples whose rays met fences, glass or the like.
    pub filtered: Vec<u32>,
    /// Samples around which there is nothing in the way of the light.
    pub open: Vec<u32>,
}

impl Wanted {
    pub fn new(samples: usize) -> Self {
        Self {
            sent: vec![None; samples],
            arrived: vec![None; samples],
            filtered: Vec::new(),
            open: Vec::new(),
        }
    }

    /// Wants what is `sent` to some samples; whether any of them may get some.
    pub fn want(&mut self, samples: &[u32], sent: impl Fn(usize) -> Option<Vec3>) -> bool {
        let mut any = false;
        for &i in samples {
            let sent = sent(i as usize);
            any |= sent.is_some();
            self.sent[i as usize] = sent;
        }
        any
    }

    /// Number of samples of a tile that need a ray.
    pub fn rays(&self, members: &[u32]) -> usize {
        members.iter().filter(|&&i| self.sent[i as usize].is_some()).count()
    }

    /// One of the samples of a tile that need a ray, from the middle of them.
    pub fn one<'m>(&self, members: &'m [u32]) -> &'m [u32] {
        let needs = |&i: &usize| self.sent[members[i] as usize].is_some();
        let middle = members.len() / 2;
        (middle..members.len()).chain(0..middle).find(needs).map_or(&[], |i| &members[i..=i])
    }

    /// Asks `seen` what arrives of the light that is sent to each of the samples, and which samples it
    /// met a filter at. Whether any arrives at the last.
    pub fn look(
        &mut self,
        members: &[u32],
        mut seen: impl FnMut(usize, Vec3, &mut Vec<u32>) -> Option<Arrival>,
    ) -> bool {
        let mut arrives = false;
        for &i in members {
            let i = i as usize;
            if let Some(colour) = self.sent[i] {
                self.arrived[i] = seen(i, colour, &mut self.filtered);
                arrives = self.arrived[i].is_some();
            }
        }
        arrives
    }

    /// What arrived, sample by sample; afterwards nothing is wanted any more.
    pub fn take(&mut self) -> impl Iterator<Item = (usize, Arrival)> + '_ {
        self.sent.fill(None);
        self.open.clear();
        self.filtered.clear();
        self.arrived.iter_mut().enumerate().filter_map(|(i, a)| a.take().map(|a| (i, a)))
    }

    /// Nothing is wanted of some samples any more, and what came is forgotten.
    pub fn forget(&mut self, samples: &[u32]) {
        for &i in samples {
            (self.sent[i as usize], self.arrived[i as usize]) = (None, None);
        }
        self.open.clear();
        self.filtered.clear();
    }
}
