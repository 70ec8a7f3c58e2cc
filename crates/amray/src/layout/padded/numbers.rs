//! Memory for a padded copy: filled once, then read at random, so in large pages where the system has them.

use std::ops::Deref;
use std::sync::Arc;

use memmap2::{Mmap, MmapMut};

/// Numbers that do not change any more. Clones share them.
#[derive(Clone, Debug)]
pub(super) struct Numbers(Arc<Mmap>);

impl Numbers {
    /// At least one number, all 0 until `fill` has been called, whose result is handed on.
    ///
    /// # Panics
    /// Where there is not so much memory.
    pub(super) fn filled<R>(count: usize, fill: impl FnOnce(&mut [f32]) -> R) -> (Self, R) {
        let mut memory = MmapMut::map_anon(count * size_of::<f32>()).expect("memory for a padded copy");
        #[cfg(target_os = "linux")]
        {
            // Small pages do as well.
            let _ = memory.advise(memmap2::Advice::HugePage);
        }
        let result = fill(bytemuck::cast_slice_mut(&mut memory));
        (Self(Arc::new(memory.make_read_only().expect("memory can be protected"))), result)
    }
}

impl Deref for Numbers {
    type Target = [f32];

    fn deref(&self) -> &[f32] {
        bytemuck::cast_slice(&self.0)
    }
}
