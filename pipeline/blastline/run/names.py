"""What the files of a result are called."""

DRIVE, TIMELINE, REPORT = "drive.wav", "timeline.json", "report.html"
EVENTS, STRETCHES = "conform.csv", "stretches.csv"
