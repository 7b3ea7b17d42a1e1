"""The lab: a door like the command line, in a browser.  `server` and `page` speak viser; the rest does not know it."""
