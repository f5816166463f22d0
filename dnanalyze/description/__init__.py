"""What is in no catalogue: residual layers, words that estimate their structure, descriptions."""
