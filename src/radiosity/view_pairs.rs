//! What a patch sees, pair by pair, with what is uncertain about it.

/// A patch as seen from the row's patch.
#[derive(Clone, Copy)]
pub struct Pair {
    pub patch: u32,
    /// Form factor.
    pub factor: f64,
    /// Roughly what it is with nothing between.
    pub guess: f64,
    /// Error of the hemicube because the view changes over the patch.
    pub curve: f64,
    /// Error of the hemicube because its cells have a size.
    pub alias: f64,
    /// Whether the form factor is to be that of the closed form.
    pub closed: bool,
    /// Uncertainty of `factor`.
    pub sigma: f64,
}

impl Pair {
    /// One of which only the form factor is known.
    pub fn seen(patch: u32, factor: f64) -> Self {
        let none = 0.0;
        Self { patch, factor, guess: none, curve: none, alias: none, closed: false, sigma: none }
    }
}

/// Most that a hemicube without void can fail to show.
const UNSHOWN: f64 = 1e-3;

/// Makes the view whole again: the form factors and the void sum to `open`, the share of the patch
/// that nothing covers, so what the closed forms
/// changed is taken from those that are uncertain, most from the most uncertain (least squares).
/// The void counts as half unknown. If nothing is uncertain and there is no void, what no cell of the
/// hemicube showed is missing, next to nothing: then all form factors grow or shrink alike.
pub fn balance(pairs: &mut [Pair], mut void: f64, open: f64) {
    // Weights of cells are of single precision: a smaller void is none.
    if void < 1e-6 {
        void = 0.0;
    }
    let void_square = 0.25 * void * void;
    // Again where a form factor would have become negative.
    for _ in 0..8 {
        let excess = pairs.iter().map(|p| p.factor).sum::<f64>() + void - open;
        let uncertain = pairs.iter().filter(|p| p.factor > 0.0);
        let squares = uncertain.map(|p| p.sigma * p.sigma).sum::<f64>() + void_square;
        if squares <= 0.0 && void == 0.0 && excess.abs() < UNSHOWN {
            let share = open / (open + excess);
            pairs.iter_mut().for_each(|p| p.factor *= share);
        }
        if squares <= 0.0 || excess.abs() < 1e-12 {
            return;
        }
        let step = excess / squares;
        for p in pairs.iter_mut().filter(|p| p.factor > 0.0) {
            p.factor = (p.factor - step * p.sigma * p.sigma).max(0.0);
        }
        void = (void - step * void_square).max(0.0);
    }
}
