//! Opens queues: which kind of queue an address is of.

use std::sync::Arc;

use super::{QueueError, address::QueueAddress, printer_queue::OpenQueue, queue_folder::QueueFolder};

impl QueueAddress {
    /// Opens the queue; a folder and its marker `.nestd-queue` are created if they are missing.
    pub fn open(&self) -> Result<OpenQueue, QueueError> {
        let Self::Folder(folder) = self;
        Ok(Arc::new(QueueFolder::open(folder)?))
    }

    /// The queue if it is there and was opened before; nothing is created.
    pub fn find(&self) -> Option<OpenQueue> {
        let Self::Folder(folder) = self;
        Some(Arc::new(QueueFolder::find(folder)?))
    }
}
